//! Object File Format: a head, counts, a vertex a line, a face a line.

use super::{
    Parsed, Surface,
    gather::Gather,
    refuse,
    text::{Line, lines, number, position},
};

pub(super) fn parse(bytes: &[u8]) -> Parsed<Surface> {
    let mut lines = lines(bytes);
    let ended = || refuse("end of file", "it comes too early");
    let Some(mut counts) = lines.next() else {
        return ended();
    };
    if let Some(rest) = head(&counts)? {
        counts.text = rest;
        if counts.text.is_empty() {
            let Some(line) = lines.next() else {
                return ended();
            };
            counts = line;
        }
    }
    let mut words = counts.words();
    let vertices: usize = number(&counts, &mut words)?;
    let faces: usize = number(&counts, &mut words)?;
    let mut gather = Gather::default();
    for _ in 0..vertices {
        let Some(line) = lines.next() else {
            return ended();
        };
        gather.vertex(|| line.name(), position(&line, &mut line.words())?)?;
    }
    for _ in 0..faces {
        let Some(line) = lines.next() else {
            return ended();
        };
        face(&mut gather, &line)?;
    }
    gather.finish("line")
}

/// What follows the keyword; `None` where the file begins with the counts.
fn head(line: &Line) -> Parsed<Option<String>> {
    let mut words = line.words();
    let Some(keyword) = words.next().and_then(|word| word.strip_suffix("OFF")) else {
        return Ok(None);
    };
    let rest: Vec<&str> = words.collect();
    // Homogeneous and higher dimensions have other rows; texture coordinates, colours and normals follow the position.
    if keyword.contains(['4', 'n']) || rest.first() == Some(&"BINARY") {
        return refuse(line.name(), "only OFF as text in three dimensions is read");
    }
    Ok(Some(rest.join(" ")))
}

fn face(gather: &mut Gather, line: &Line) -> Parsed<()> {
    let mut words = line.words();
    let count: usize = number(line, &mut words)?;
    let mut corners = Vec::new();
    for _ in 0..count {
        corners.push(number(line, &mut words)?);
    }
    gather.face(line.number, || line.name(), &corners)
}
