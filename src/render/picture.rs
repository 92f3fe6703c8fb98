//! Pixels, text on them, and labelled contact sheets.

use super::font;

/// An 8-bit sRGB picture, rows from the top.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Picture {
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Four bytes a pixel: red, green and blue in sRGB, alpha.
    pub rgba: Vec<u8>,
}

/// Enlargement of the font in a sheet.
pub(super) const TEXT_SCALE: u32 = 2;
const PAPER: [u8; 3] = [250, 250, 249];
/// Colour of text.
pub(super) const INK: [u8; 3] = [38, 40, 46];
const GAP: u32 = 8;
const LABEL: u32 = font::HEIGHT * TEXT_SCALE + 12;

impl Picture {
    /// A picture of one opaque colour.
    pub fn filled(width: u32, height: u32, rgb: [u8; 3]) -> Self {
        let pixel = [rgb[0], rgb[1], rgb[2], 255];
        Self {
            width,
            height,
            rgba: pixel.repeat(width as usize * height as usize),
        }
    }

    /// The pixel in column `x` and row `y`; both must be inside.
    pub fn pixel(&self, x: u32, y: u32) -> [u8; 4] {
        let at = self.offset(x, y);
        [0, 1, 2, 3].map(|c| self.rgba[at + c])
    }

    /// Fills the rectangle at (`x`, `y`) as far as it lies inside.
    pub fn rectangle(&mut self, x: u32, y: u32, width: u32, height: u32, rgb: [u8; 3]) {
        let right = x.saturating_add(width).min(self.width);
        let bottom = y.saturating_add(height).min(self.height);
        for row in y..bottom {
            for column in x..right {
                let at = self.offset(column, row);
                self.rgba[at..at + 4].copy_from_slice(&[rgb[0], rgb[1], rgb[2], 255]);
            }
        }
    }

    /// Copies `other` with its corner at (`x`, `y`), as far as it lies inside.
    pub fn paste(&mut self, other: &Self, x: u32, y: u32) {
        let columns = other.width.min(self.width.saturating_sub(x));
        let rows = other.height.min(self.height.saturating_sub(y));
        for row in 0..rows {
            let (from, to) = (other.offset(0, row), self.offset(x, y + row));
            let bytes = 4 * columns as usize;
            self.rgba[to..to + bytes].copy_from_slice(&other.rgba[from..from + bytes]);
        }
    }

    /// Writes one line of printable ASCII with its corner at (`x`, `y`), each font pixel `scale` pixels wide.
    pub fn text(&mut self, x: u32, y: u32, scale: u32, rgb: [u8; 3], line: &str) {
        for (i, c) in line.chars().enumerate() {
            let left = x + i as u32 * font::ADVANCE * scale;
            for (column, bits) in font::glyph(c).into_iter().enumerate() {
                for row in (0..font::HEIGHT).filter(|row| bits >> row & 1 == 1) {
                    let column = column as u32 * scale;
                    self.rectangle(left + column, y + row * scale, scale, scale, rgb);
                }
            }
        }
    }

    fn offset(&self, x: u32, y: u32) -> usize {
        4 * (y as usize * self.width as usize + x as usize)
    }
}

/// Pixels across `line` when written at `scale`.
pub(super) fn text_width(line: &str, scale: u32) -> u32 {
    let glyphs = line.chars().count() as u32;
    (glyphs * font::ADVANCE).saturating_sub(font::ADVANCE - font::WIDTH) * scale
}

/// Arranges pictures in rows of `columns`, each centred under its label; no pictures give an empty picture.
///
/// Cells are as large as the largest picture; a label that is too long for its cell is cut off.
pub fn sheet<L: AsRef<str>>(tiles: &[(L, Picture)], columns: usize) -> Picture {
    let columns = columns.clamp(1, tiles.len().max(1)) as u32;
    let rows = (tiles.len() as u32).div_ceil(columns);
    let width = tiles.iter().map(|(_, p)| p.width).max().unwrap_or(0);
    let height = tiles.iter().map(|(_, p)| p.height).max().unwrap_or(0);
    let (step_x, step_y) = (width + GAP, LABEL + height + GAP);
    let mut out = match tiles {
        [] => return Picture::filled(0, 0, PAPER),
        _ => Picture::filled(columns * step_x + GAP, rows * step_y + GAP, PAPER),
    };
    for (i, (label, picture)) in tiles.iter().enumerate() {
        let (column, row) = (i as u32 % columns, i as u32 / columns);
        let (x, y) = (GAP + column * step_x, GAP + row * step_y);
        write_label(&mut out, x, y, width, label.as_ref());
        let centred = (
            x + (width - picture.width) / 2,
            y + LABEL + (height - picture.height) / 2,
        );
        out.paste(picture, centred.0, centred.1);
    }
    out
}

fn write_label(out: &mut Picture, x: u32, y: u32, width: u32, label: &str) {
    let fits = (width + TEXT_SCALE) / (font::ADVANCE * TEXT_SCALE);
    let line: String = label.chars().take(fits as usize).collect();
    let left = x + (width - text_width(&line, TEXT_SCALE)) / 2;
    out.text(left, y + 6, TEXT_SCALE, INK, &line);
}

#[cfg(test)]
mod tests {
    use super::*;

    const RED: [u8; 3] = [200, 10, 20];

    fn dark_pixels(picture: &Picture, x: std::ops::Range<u32>, y: std::ops::Range<u32>) -> usize {
        y.flat_map(|row| x.clone().map(move |column| (column, row)))
            .filter(|&(column, row)| picture.pixel(column, row)[..3] == INK)
            .count()
    }

    #[test]
    fn sheet_puts_tiles_in_rows_under_their_labels() {
        let tile = |v| Picture::filled(60, 40, [v, v, v]);
        let tiles = [("lbs", tile(1)), ("dqs", tile(2)), ("implicit", tile(3))];
        let out = sheet(&tiles, 2);
        assert_eq!((out.width, out.height), (2 * 68 + 8, 2 * (LABEL + 48) + 8));
        let corner = |column: u32, row: u32| (8 + column * 68, 8 + LABEL + row * (LABEL + 48));
        for (value, at) in [(1, corner(0, 0)), (2, corner(1, 0)), (3, corner(0, 1))] {
            assert_eq!(out.pixel(at.0, at.1), [value, value, value, 255]);
            assert_eq!(out.pixel(at.0 + 59, at.1 + 39)[0], value);
            assert_ne!(out.pixel(at.0 - 1, at.1)[0], value);
        }
        assert!(dark_pixels(&out, 8..68, 8..8 + LABEL) > 50);
        let empty_cell = corner(1, 1);
        assert_eq!(out.pixel(empty_cell.0, empty_cell.1)[..3], PAPER);
    }

    #[test]
    fn small_tiles_are_centred_and_long_labels_cut() {
        let tiles = [
            ("a label far too long for it", Picture::filled(40, 40, RED)),
            ("b", Picture::filled(20, 10, RED)),
        ];
        let out = sheet(&tiles, 5);
        assert_eq!(out.width, 2 * 48 + 8);
        assert_eq!(out.pixel(56 + 10, 8 + LABEL + 15)[..3], RED);
        assert_eq!(out.pixel(56 + 9, 8 + LABEL + 15)[..3], PAPER);
        assert_eq!(dark_pixels(&out, 48..56, 0..out.height), 0);
    }

    #[test]
    fn no_tiles_give_an_empty_picture() {
        assert!(sheet::<&str>(&[], 3).rgba.is_empty());
    }

    #[test]
    fn text_scales_and_is_clipped_at_the_border() {
        let mut picture = Picture::filled(30, 20, PAPER);
        picture.text(0, 0, 2, INK, "I");
        assert_eq!(dark_pixels(&picture, 0..30, 0..20), 4 * (7 + 4));
        picture.text(25, 15, 2, INK, "WWWW");
        assert!(dark_pixels(&picture, 25..30, 15..20) > 0);
    }

    #[test]
    fn every_printable_character_has_its_own_glyph() {
        let glyphs: std::collections::HashSet<_> = (' '..='~').map(font::glyph).collect();
        assert_eq!(glyphs.len(), 95);
        assert_eq!(font::glyph('é'), font::glyph('?'));
    }
}
