//! The values of a PLY file one after the other, from text or bytes.

use super::{
    super::{Parsed, refuse},
    header::Scalar,
};

/// Where values come from.
pub(super) trait Values {
    /// Row `row` of an element begins.
    fn start(&mut self, element: &str, row: usize);
    /// How errors name the present place.
    fn name(&self) -> String;
    /// The next value.
    fn next(&mut self, scalar: Scalar) -> Parsed<f64>;
}

/// Words of lines; errors name the line.
pub(super) struct Text<'a> {
    rest: &'a [u8],
    line: usize,
}

impl<'a> Text<'a> {
    pub(super) fn new(rest: &'a [u8], lines: usize) -> Self {
        let line = lines + 1;
        Self { rest, line }
    }
}

impl Values for Text<'_> {
    fn start(&mut self, _: &str, _: usize) {}

    fn name(&self) -> String {
        format!("line {}", self.line)
    }

    fn next(&mut self, _: Scalar) -> Parsed<f64> {
        while let [first, rest @ ..] = self.rest
            && first.is_ascii_whitespace()
        {
            self.line += usize::from(*first == b'\n');
            self.rest = rest;
        }
        let end = self.rest.iter().position(u8::is_ascii_whitespace);
        let (word, rest) = self.rest.split_at(end.unwrap_or(self.rest.len()));
        if word.is_empty() {
            return refuse("end of file", "it comes too early");
        }
        self.rest = rest;
        let word = String::from_utf8_lossy(word);
        word.parse()
            .or_else(|_| refuse(self.name(), format!("{word:?} is not a number")))
    }
}

/// Bytes; errors name the element and its row.
pub(super) struct Binary<'a> {
    rest: &'a [u8],
    big: bool,
    element: String,
    row: usize,
}

impl<'a> Binary<'a> {
    pub(super) fn new(rest: &'a [u8], big: bool) -> Self {
        Self {
            rest,
            big,
            element: String::new(),
            row: 0,
        }
    }

    fn take<const N: usize>(&mut self) -> Parsed<[u8; N]> {
        let Some((bytes, rest)) = self.rest.split_first_chunk::<N>() else {
            return refuse(self.name(), "the file ends within it");
        };
        self.rest = rest;
        let mut bytes = *bytes;
        if self.big {
            bytes.reverse();
        }
        Ok(bytes)
    }
}

impl Values for Binary<'_> {
    fn start(&mut self, element: &str, row: usize) {
        if self.element != element {
            element.clone_into(&mut self.element);
        }
        self.row = row;
    }

    fn name(&self) -> String {
        format!("{} {}", self.element, self.row)
    }

    fn next(&mut self, scalar: Scalar) -> Parsed<f64> {
        Ok(match scalar {
            Scalar::I8 => f64::from(i8::from_le_bytes(self.take()?)),
            Scalar::U8 => f64::from(u8::from_le_bytes(self.take()?)),
            Scalar::I16 => f64::from(i16::from_le_bytes(self.take()?)),
            Scalar::U16 => f64::from(u16::from_le_bytes(self.take()?)),
            Scalar::I32 => f64::from(i32::from_le_bytes(self.take()?)),
            Scalar::U32 => f64::from(u32::from_le_bytes(self.take()?)),
            Scalar::F32 => f64::from(f32::from_le_bytes(self.take()?)),
            Scalar::F64 => f64::from_le_bytes(self.take()?),
        })
    }
}
