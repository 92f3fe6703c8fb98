//! Lines and numbers of text files.

use std::str::FromStr;

use super::{Parsed, refuse};

/// A line without its comment and its number from 1; a line that ends in `\` is one with the next.
pub(super) struct Line {
    pub(super) number: usize,
    pub(super) text: String,
}

impl Line {
    /// How errors name it.
    pub(super) fn name(&self) -> String {
        format!("line {}", self.number)
    }

    /// The words; there may be none.
    pub(super) fn words(&self) -> impl Iterator<Item = &str> {
        self.text.split_ascii_whitespace()
    }
}

/// All lines that hold something; bytes that are no UTF-8 stand in names and comments only, or are refused as numbers.
pub(super) fn lines(bytes: &[u8]) -> impl Iterator<Item = Line> {
    let mut rest = bytes.split(|&byte| byte == b'\n').enumerate();
    std::iter::from_fn(move || {
        loop {
            let (row, first) = rest.next()?;
            let mut text = bare(first);
            while let Some(head) = text.strip_suffix('\\') {
                let more = rest.next().map(|(_, more)| bare(more));
                text = format!("{head} {}", more.unwrap_or_default());
            }
            if !text.trim().is_empty() {
                let number = row + 1;
                return Some(Line { number, text });
            }
        }
    })
}

fn bare(line: &[u8]) -> String {
    let end = line.iter().position(|&byte| byte == b'#');
    let text = String::from_utf8_lossy(&line[..end.unwrap_or(line.len())]);
    text.trim_end().to_owned()
}

/// The next word as a number.
pub(super) fn number<'a, T: FromStr>(
    line: &Line,
    words: &mut impl Iterator<Item = &'a str>,
) -> Parsed<T> {
    let Some(word) = words.next() else {
        return refuse(line.name(), "a number is missing");
    };
    match word.parse() {
        Ok(number) => Ok(number),
        Err(_) => refuse(line.name(), format!("{word:?} is not such a number")),
    }
}

/// The next three words as a position.
pub(super) fn position<'a>(
    line: &Line,
    words: &mut impl Iterator<Item = &'a str>,
) -> Parsed<[f64; 3]> {
    Ok([
        number(line, words)?,
        number(line, words)?,
        number(line, words)?,
    ])
}
