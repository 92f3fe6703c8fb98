//! `cargo xtask compare`: how much two pictures differ.

use std::{fs::File, io::BufReader, path::Path};

use crate::Result;

/// Most that two pictures may differ by on average where the caller does not say, in 255ths of a channel.
const MEAN: f64 = 1.0;

/// Red, green and blue of each pixel.
struct Picture {
    size: (u32, u32),
    rgb: Vec<[u8; 3]>,
}

/// Prints the mean and greatest difference of two PNGs and fails where the mean passes what the third argument says.
pub(crate) fn run(arguments: &[String]) -> Result<()> {
    let (a, b, allowed) = match arguments {
        [a, b] => (a, b, MEAN),
        [a, b, mean] => (a, b, mean.parse().map_err(|e| format!("{mean}: {e}"))?),
        _ => return Err("compare takes two PNG files and the greatest mean difference".into()),
    };
    let (mean, most) = difference(&read(Path::new(a))?, &read(Path::new(b))?)?;
    let found = format!("{a} and {b} differ by {mean:.4} of 255 a channel, at most by {most}");
    if mean > allowed {
        return Err(format!("{found}; up to {allowed} on average are allowed"));
    }
    println!("{found}");
    Ok(())
}

fn read(path: &Path) -> Result<Picture> {
    let about = |e: &dyn std::fmt::Display| format!("{}: {e}", path.display());
    let file = File::open(path).map_err(|e| about(&e))?;
    let mut reader = png::Decoder::new(BufReader::new(file))
        .read_info()
        .map_err(|e| about(&e))?;
    let bytes = reader.output_buffer_size();
    let mut pixels = vec![0; bytes.ok_or_else(|| about(&"too large"))?];
    let frame = reader.next_frame(&mut pixels).map_err(|e| about(&e))?;
    let channels = match (frame.color_type, frame.bit_depth) {
        (png::ColorType::Rgb, png::BitDepth::Eight) => 3,
        (png::ColorType::Rgba, png::BitDepth::Eight) => 4,
        other => {
            return Err(about(&format_args!(
                "{other:?} is neither RGB nor RGBA of 8 bits"
            )));
        }
    };
    let pixel = |p: &[u8]| [p[0], p[1], p[2]];
    Ok(Picture {
        size: (frame.width, frame.height),
        rgb: pixels.chunks_exact(channels).map(pixel).collect(),
    })
}

/// Mean and greatest difference of a channel.
fn difference(a: &Picture, b: &Picture) -> Result<(f64, u8)> {
    if a.size != b.size || a.rgb.is_empty() {
        return Err(format!("sizes {:?} and {:?}", a.size, b.size));
    }
    let (a, b) = (a.rgb.as_flattened(), b.rgb.as_flattened());
    let each = || a.iter().zip(b).map(|(a, b)| a.abs_diff(*b));
    let sum: u64 = each().map(u64::from).sum();
    Ok((sum as f64 / a.len() as f64, each().max().unwrap_or(0)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn picture(rgb: &[[u8; 3]]) -> Picture {
        Picture {
            size: (rgb.len() as u32, 1),
            rgb: rgb.to_vec(),
        }
    }

    #[test]
    fn differences_are_averaged_over_channels() {
        let a = picture(&[[0, 10, 20], [255, 0, 0]]);
        let b = picture(&[[3, 10, 17], [249, 0, 0]]);
        assert_eq!(difference(&a, &b), Ok((2.0, 6)));
        assert_eq!(difference(&a, &a), Ok((0.0, 0)));
        assert!(difference(&a, &picture(&[[0; 3]])).is_err());
        assert!(difference(&picture(&[]), &picture(&[])).is_err());
    }
}
