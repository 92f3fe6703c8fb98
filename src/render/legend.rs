//! The key to a picture's colours.

use super::{
    ERROR_SCALE, Picture, STATES, Shading, colour, font,
    picture::{INK, TEXT_SCALE, text_width},
};

const MARGIN: u32 = 12;
const SWATCH: u32 = font::HEIGHT * TEXT_SCALE;
const RAMP: u32 = 160;

/// Writes the key to `shading` into the picture's lower left corner; nothing where colours carry no meaning.
pub fn legend(picture: &mut Picture, shading: Shading) {
    match shading {
        Shading::State => states(picture),
        Shading::Error => error_scale(picture),
        Shading::Skin | Shading::Bone | Shading::Normals => {}
    }
}

fn states(picture: &mut Picture) {
    let line = SWATCH + 6;
    let top = (picture.height).saturating_sub(MARGIN + line * STATES.len() as u32);
    for (i, name) in STATES.iter().enumerate() {
        let y = top + line * i as u32;
        let rgb = colour::encode(colour::state_colour(i as u8));
        picture.rectangle(MARGIN, y, SWATCH, SWATCH, rgb);
        picture.text(MARGIN + SWATCH + 8, y, TEXT_SCALE, INK, name);
    }
}

fn error_scale(picture: &mut Picture) {
    let text = SWATCH + 4;
    let top = picture.height.saturating_sub(MARGIN + SWATCH + 2 * text);
    picture.text(MARGIN, top, TEXT_SCALE, INK, "|f - iso|");
    for x in 0..RAMP {
        let error = ERROR_SCALE * x as f32 / (RAMP - 1) as f32;
        let rgb = colour::encode(colour::error_colour(error));
        picture.rectangle(MARGIN + x, top + text, 1, SWATCH, rgb);
    }
    let most = format!("{ERROR_SCALE}+");
    let (below, right) = (top + text + SWATCH + 4, MARGIN + RAMP);
    picture.text(MARGIN, below, TEXT_SCALE, INK, "0");
    let left = right.saturating_sub(text_width(&most, TEXT_SCALE));
    picture.text(left, below, TEXT_SCALE, INK, &most);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_meaningful_colours_have_a_key_and_it_fits() {
        for (shading, drawn) in [
            (Shading::Skin, false),
            (Shading::State, true),
            (Shading::Error, true),
        ] {
            let blank = Picture::filled(240, 140, [255, 255, 255]);
            let mut picture = blank.clone();
            legend(&mut picture, shading);
            assert_eq!(picture != blank, drawn);
        }
    }
}
