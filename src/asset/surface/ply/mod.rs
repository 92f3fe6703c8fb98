//! PLY as text or binary: `x y z` of the vertices, `vertex_indices` of the faces; other properties are passed over.

mod header;
mod values;

use header::{Element, Header, Property};
use values::{Binary, Text, Values};

use super::{Parsed, Surface, gather::Gather, refuse};

pub(super) fn parse(bytes: &[u8]) -> Parsed<Surface> {
    let (header, body) = header::parse(bytes)?;
    match header.format {
        header::Format::Text => read(&header, Text::new(&bytes[body..], header.lines)),
        header::Format::Little => read(&header, Binary::new(&bytes[body..], false)),
        header::Format::Big => read(&header, Binary::new(&bytes[body..], true)),
    }
}

fn read(header: &Header, mut values: impl Values) -> Parsed<Surface> {
    let mut gather = Gather::default();
    for element in &header.elements {
        // Nothing to read, however many there are said to be.
        if element.properties.is_empty() {
            continue;
        }
        for row in 0..element.count {
            values.start(&element.name, row);
            match element.name.as_str() {
                "vertex" => vertex(element, &mut values, &mut gather)?,
                "face" => face(element, &mut values, &mut gather, row)?,
                _ => {
                    for property in &element.properties {
                        skip(property, &mut values)?;
                    }
                }
            }
        }
    }
    gather.finish("face")
}

fn vertex(element: &Element, values: &mut impl Values, gather: &mut Gather) -> Parsed<()> {
    let mut xyz = [f64::NAN; 3];
    for property in &element.properties {
        let axis = ["x", "y", "z"].iter().position(|n| *n == property.name);
        match (axis, property.list) {
            (Some(axis), None) => xyz[axis] = values.next(property.scalar)?,
            _ => skip(property, values)?,
        }
    }
    gather.vertex(|| values.name(), xyz)
}

fn face(
    element: &Element,
    values: &mut impl Values,
    gather: &mut Gather,
    row: usize,
) -> Parsed<()> {
    let mut corners = Vec::new();
    for property in &element.properties {
        let named = matches!(property.name.as_str(), "vertex_indices" | "vertex_index");
        let Some(count) = property.list.filter(|_| named) else {
            skip(property, values)?;
            continue;
        };
        for _ in 0..length(values.next(count)?, values)? {
            let index = values.next(property.scalar)?;
            if index < 0.0 || index > f64::from(u32::MAX) || index.fract() != 0.0 {
                return refuse(values.name(), format!("index {index}"));
            }
            corners.push(index as u32);
        }
    }
    gather.face(row, || values.name(), &corners)
}

fn skip(property: &Property, values: &mut impl Values) -> Parsed<()> {
    let count = match property.list {
        None => 1,
        Some(count) => length(values.next(count)?, values)?,
    };
    for _ in 0..count {
        values.next(property.scalar)?;
    }
    Ok(())
}

/// A list's length; each item is then read, so that no length outlives the file.
fn length(count: f64, values: &impl Values) -> Parsed<u64> {
    if count < 0.0 || count.fract() != 0.0 {
        return refuse(values.name(), format!("a list of {count}"));
    }
    Ok(count as u64)
}
