//! Wavefront OBJ: `v` and `f`; everything else is passed over.

use super::{
    Parsed, Surface,
    gather::Gather,
    refuse,
    text::{Line, lines, position},
};

pub(super) fn parse(bytes: &[u8]) -> Parsed<Surface> {
    let mut gather = Gather::default();
    let mut corners = Vec::new();
    for line in lines(bytes) {
        let mut words = line.words();
        match words.next() {
            Some("v") => gather.vertex(|| line.name(), position(&line, &mut words)?)?,
            Some("f") => {
                corners.clear();
                for word in words {
                    corners.push(corner(&line, word, gather.vertices())?);
                }
                gather.face(line.number, || line.name(), &corners)?;
            }
            _ => {}
        }
    }
    gather.finish("line")
}

/// `v`, `v/vt`, `v//vn` or `v/vt/vn`: rows from 1, or from the end where negative.
fn corner(line: &Line, word: &str, vertices: usize) -> Parsed<u32> {
    let first = word.split('/').next().unwrap_or(word);
    let row = match first.parse::<i64>() {
        Ok(row) if row > 0 => row - 1,
        Ok(row) if row < 0 => vertices as i64 + row,
        _ => return refuse(line.name(), format!("{word:?} is no corner of a face")),
    };
    u32::try_from(row).or_else(|_| {
        refuse(
            line.name(),
            format!("corner {word:?} with {vertices} vertices before it"),
        )
    })
}
