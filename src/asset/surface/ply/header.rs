//! The head of a PLY file: its format, elements and their properties.

use super::super::{Parsed, refuse};

/// How the values that follow are written.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Format {
    Text,
    Little,
    Big,
}

/// Type of a value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Scalar {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

#[derive(Debug)]
pub(super) struct Property {
    pub(super) name: String,
    /// Of the value, or of a list's items.
    pub(super) scalar: Scalar,
    /// Type of the length, of a list.
    pub(super) list: Option<Scalar>,
}

#[derive(Debug)]
pub(super) struct Element {
    pub(super) name: String,
    pub(super) count: usize,
    pub(super) properties: Vec<Property>,
}

#[derive(Debug)]
pub(super) struct Header {
    pub(super) format: Format,
    pub(super) elements: Vec<Element>,
    /// Lines of the head, before the values.
    pub(super) lines: usize,
}

/// The head and where the values begin.
pub(super) fn parse(bytes: &[u8]) -> Parsed<(Header, usize)> {
    let mut format = None;
    let mut elements: Vec<Element> = Vec::new();
    let mut at = 0;
    for number in 1.. {
        let rest = &bytes[at..];
        let Some(end) = rest.iter().position(|&byte| byte == b'\n') else {
            return refuse("header", "it does not end");
        };
        at += end + 1;
        let text = String::from_utf8_lossy(&rest[..end]);
        let words: Vec<&str> = text.split_ascii_whitespace().collect();
        let name = format!("line {number}");
        match words.as_slice() {
            ["ply"] if number == 1 => {}
            _ if number == 1 => return refuse(name, "the file does not begin with \"ply\""),
            ["comment" | "obj_info", ..] | [] => {}
            ["format", kind, _version] => format = Some(kind_of(kind, &name)?),
            ["element", element, count] => elements.push(Element {
                name: (*element).to_owned(),
                count: count
                    .parse()
                    .or_else(|_| refuse(name, format!("count {count:?}")))?,
                properties: Vec::new(),
            }),
            ["property", of @ ..] => match elements.last_mut() {
                Some(element) => element.properties.push(property(of, &name)?),
                None => return refuse(name, "a property of no element"),
            },
            ["end_header"] => return finish(format, elements, number).map(|header| (header, at)),
            _ => return refuse(name, format!("{:?} is not understood", text.trim())),
        }
    }
    refuse("header", "it does not end")
}

fn finish(format: Option<Format>, elements: Vec<Element>, lines: usize) -> Parsed<Header> {
    let Some(format) = format else {
        return refuse("header", "no line says the format");
    };
    let has = |element: &str, names: &[&str], list: bool| {
        let mut of = elements.iter().filter(|e| e.name == element);
        of.any(|e| {
            let mut of = e.properties.iter().filter(|p| p.list.is_some() == list);
            of.any(|p| names.contains(&p.name.as_str()))
        })
    };
    for axis in ["x", "y", "z"] {
        if !has("vertex", &[axis], false) {
            return refuse("header", format!("vertices without a property {axis}"));
        }
    }
    if !has("face", &["vertex_indices", "vertex_index"], true) {
        return refuse("header", "faces without a list vertex_indices");
    }
    Ok(Header {
        format,
        elements,
        lines,
    })
}

fn kind_of(kind: &str, name: &str) -> Parsed<Format> {
    match kind {
        "ascii" => Ok(Format::Text),
        "binary_little_endian" => Ok(Format::Little),
        "binary_big_endian" => Ok(Format::Big),
        _ => refuse(name, format!("format {kind:?}")),
    }
}

fn property(words: &[&str], line: &str) -> Parsed<Property> {
    let (scalar, list, name) = match words {
        ["list", count, scalar, name] => (scalar, Some(count), name),
        [scalar, name] => (scalar, None, name),
        _ => return refuse(line, "a property is a type and a name"),
    };
    let list = list.map(|count| scalar_of(count, line)).transpose()?;
    if matches!(list, Some(Scalar::F32 | Scalar::F64)) {
        return refuse(line, "the length of a list is a whole number");
    }
    Ok(Property {
        name: (*name).to_owned(),
        scalar: scalar_of(scalar, line)?,
        list,
    })
}

fn scalar_of(word: &str, line: &str) -> Parsed<Scalar> {
    Ok(match word {
        "char" | "int8" => Scalar::I8,
        "uchar" | "uint8" => Scalar::U8,
        "short" | "int16" => Scalar::I16,
        "ushort" | "uint16" => Scalar::U16,
        "int" | "int32" => Scalar::I32,
        "uint" | "uint32" => Scalar::U32,
        "float" | "float32" => Scalar::F32,
        "double" | "float64" => Scalar::F64,
        _ => return refuse(line, format!("type {word:?}")),
    })
}
