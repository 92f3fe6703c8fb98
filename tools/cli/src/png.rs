//! Pictures as PNG files.

use dermis::{Error, Result, render::Picture};

/// The bytes of a PNG file that shows `picture`; `name` is the file, for errors.
pub(crate) fn encode(name: &std::path::Path, picture: &Picture) -> Result<Vec<u8>> {
    write(picture).map_err(|e| Error::asset(name, "PNG", e.to_string()))
}

fn write(picture: &Picture) -> std::result::Result<Vec<u8>, png::EncodingError> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, picture.width, picture.height);
    encoder.set_color(png::ColorType::Rgba);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
    let mut writer = encoder.write_header()?;
    writer.write_image_data(&picture.rgba)?;
    writer.finish()?;
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use std::{io::Cursor, path::Path};

    use super::*;

    #[test]
    fn what_was_encoded_decodes_to_the_same_pixels() {
        let mut picture = Picture::filled(37, 11, [200, 30, 4]);
        picture.rectangle(3, 2, 9, 20, [1, 255, 77]);
        let bytes = encode(Path::new("a.png"), &picture).unwrap();
        let mut reader = png::Decoder::new(Cursor::new(bytes)).read_info().unwrap();
        let mut rgba = vec![0; reader.output_buffer_size().unwrap()];
        let info = reader.next_frame(&mut rgba).unwrap();
        assert_eq!((info.width, info.height), (37, 11));
        assert_eq!(rgba, picture.rgba);
    }

    #[test]
    fn an_empty_picture_is_an_error_that_names_the_file() {
        let empty = Picture::filled(0, 0, [0, 0, 0]);
        let error = encode(Path::new("a.png"), &empty).unwrap_err().to_string();
        assert!(error.starts_with("a.png: PNG"), "{error}");
    }
}
