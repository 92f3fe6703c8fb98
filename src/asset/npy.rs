//! Arrays of NumPy: version 1 to 3, little-endian floats in C order.

use std::{
    fs::File,
    io::{BufReader, Read, Seek, SeekFrom},
    path::Path,
};

use super::write_atomic;
use crate::{Error, Result};

/// What the file says before its numbers.
#[derive(Debug)]
pub(super) struct Head {
    pub(super) shape: Vec<usize>,
    pub(super) kind: Kind,
    /// Where the numbers begin.
    start: u64,
}

/// Kind of the numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    /// `<f4`
    Single = 4,
    /// `<f8`
    Double = 8,
}

impl Kind {
    fn name(self) -> &'static str {
        match self {
            Self::Single => "'<f4'",
            Self::Double => "'<f8'",
        }
    }
}

impl Head {
    /// Reads the head, of numbers of one of these kinds, and checks the file's length against it.
    pub(super) fn read(path: &Path, kinds: &[Kind]) -> Result<Self> {
        let system = |e| Error::file(path, e);
        let mut file = File::open(path).map_err(system)?;
        let length = file.metadata().map_err(system)?.len();
        let mut bytes = Vec::new();
        file.by_ref()
            .take(1 << 16)
            .read_to_end(&mut bytes)
            .map_err(system)?;
        let head = parse(&bytes, kinds).map_err(|reason| Error::asset(path, "header", reason))?;
        let size = head.kind as u128;
        let sizes = head.shape.iter().map(|&n| n as u128);
        let count = sizes.fold(1u128, u128::saturating_mul);
        let wanted = count
            .saturating_mul(size)
            .saturating_add(u128::from(head.start));
        if wanted != u128::from(length) {
            let reason = format!(
                "shape {:?} makes {wanted} bytes, the file has {length}",
                head.shape
            );
            return Err(Error::asset(path, "shape", reason));
        }
        Ok(head)
    }

    /// The file from its first number on.
    pub(super) fn numbers(&self, path: &Path) -> Result<BufReader<File>> {
        let system = |e| Error::file(path, e);
        let mut file = BufReader::new(File::open(path).map_err(system)?);
        file.seek(SeekFrom::Start(self.start)).map_err(system)?;
        Ok(file)
    }
}

/// Reads a NumPy array of rows of `N` numbers, `<f4` or `<f8` in C order; any number of rows.
///
/// # Errors
/// [`Error::File`] where the system refuses; [`Error::Asset`] naming the header or shape that is wrong, or the row with a
/// number that is not finite.
pub fn load_rows<const N: usize>(path: &Path) -> Result<Vec<[f64; N]>> {
    let head = Head::read(path, &[Kind::Single, Kind::Double])?;
    let rows = match head.shape[..] {
        [rows, columns] if columns == N => rows,
        _ => {
            let reason = format!("{:?}, not rows of {N}", head.shape);
            return Err(Error::asset(path, "shape", reason));
        }
    };
    let mut file = head.numbers(path)?;
    let mut bytes = vec![0; N * head.kind as usize];
    let mut all = Vec::with_capacity(rows);
    for row in 0..rows {
        file.read_exact(&mut bytes)
            .map_err(|e| Error::file(path, e))?;
        let mut numbers = [0.0; N];
        match head.kind {
            Kind::Single => {
                for (x, b) in numbers.iter_mut().zip(bytes.as_chunks::<4>().0) {
                    *x = f64::from(f32::from_le_bytes(*b));
                }
            }
            Kind::Double => {
                for (x, b) in numbers.iter_mut().zip(bytes.as_chunks::<8>().0) {
                    *x = f64::from_le_bytes(*b);
                }
            }
        }
        if let Some(column) = numbers.iter().position(|x| !x.is_finite()) {
            let reason = format!("column {column} is not finite");
            return Err(Error::asset(path, format!("row {row}"), reason));
        }
        all.push(numbers);
    }
    Ok(all)
}

/// Writes rows of `N` numbers as a NumPy array, `<f8` in C order.
///
/// # Errors
/// [`Error::File`] where the system refuses.
pub fn write_rows<const N: usize>(path: &Path, rows: &[[f64; N]]) -> Result<()> {
    let shape = format!("({}, {N})", rows.len());
    let text = format!("{{'descr': '<f8', 'fortran_order': False, 'shape': {shape}, }}");
    // The numbers begin at a multiple of 64 bytes.
    let size = (10 + text.len() + 1).next_multiple_of(64) - 10;
    write_atomic(path, |out| {
        out.write_all(b"\x93NUMPY\x01\x00")?;
        out.write_all(&(size as u16).to_le_bytes())?;
        writeln!(out, "{text:<width$}", width = size - 1)?;
        for number in rows.as_flattened() {
            out.write_all(&number.to_le_bytes())?;
        }
        Ok(())
    })
}

/// The head, or what is wrong with it.
fn parse(bytes: &[u8], kinds: &[Kind]) -> Result<Head, String> {
    let Some(rest) = bytes.strip_prefix(b"\x93NUMPY") else {
        return Err("this is no NumPy file".into());
    };
    let (size, at): (usize, usize) = match *rest {
        [1, _, a, b, ..] => (usize::from(u16::from_le_bytes([a, b])), 10),
        [2 | 3, _, a, b, c, d, ..] => (u32::from_le_bytes([a, b, c, d]) as usize, 12),
        _ => return Err("a version of NumPy's format that is not known".into()),
    };
    let Some(text) = bytes.get(at..at.saturating_add(size)) else {
        return Err("the file ends within it".into());
    };
    let text = String::from_utf8_lossy(text);
    let kind = value(&text, "descr").unwrap_or_default();
    let found = kinds.iter().find(|k| kind.starts_with(k.name()));
    let Some(&kind) = found else {
        let names: Vec<&str> = kinds.iter().map(|k| k.name()).collect();
        let names = names.join(" and ");
        return Err(format!("numbers of another kind than {names}: {kind}"));
    };
    if !value(&text, "fortran_order").is_some_and(|v| v.starts_with("False")) {
        return Err("the array is not in C order".into());
    }
    let shape = value(&text, "shape").and_then(|v| v.strip_prefix('(')?.split_once(')'));
    let (shape, _) = shape.ok_or("no shape")?;
    let sizes = shape.split(',').map(str::trim).filter(|w| !w.is_empty());
    let sizes: Option<Vec<usize>> = sizes.map(|w| w.parse().ok()).collect();
    Ok(Head {
        shape: sizes.ok_or_else(|| format!("shape ({shape})"))?,
        kind,
        start: (at + size) as u64,
    })
}

/// What follows a key of the head's dictionary.
fn value<'a>(text: &'a str, key: &str) -> Option<&'a str> {
    let (_, rest) = text.split_once(&format!("'{key}'"))?;
    Some(rest.trim_start().strip_prefix(':')?.trim_start())
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use std::fs;

    use super::*;

    #[test]
    fn rows_come_back_as_they_were_and_damage_is_named() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("rows.npy");
        let rows = [[1.5, -2.0, f64::MIN_POSITIVE], [0.1, 1e300, 7.0]];
        write_rows(&path, &rows).unwrap();
        assert_eq!(load_rows::<3>(&path).unwrap(), rows);
        let bytes = fs::read(&path).unwrap();
        assert_eq!((bytes.len() - 48) % 64, 0);
        write_rows::<3>(&path, &[]).unwrap();
        assert_eq!(load_rows::<3>(&path).unwrap(), [[0.0; 3]; 0]);
        let refusal = |bytes: &[u8]| {
            fs::write(&path, bytes).unwrap();
            load_rows::<3>(&path).unwrap_err().to_string()
        };
        let mut bad = bytes.clone();
        let end = bad.len();
        bad[end - 8..].copy_from_slice(&f64::INFINITY.to_le_bytes());
        assert!(refusal(&bad).ends_with("rows.npy: row 1: column 2 is not finite"));
        assert!(refusal(&bytes[..end - 1]).contains("bytes"));
        assert!(refusal(b"row,column").contains("no NumPy"));
        write_rows(&path, &[[0.0; 2]; 3]).unwrap();
        let error = load_rows::<3>(&path).unwrap_err().to_string();
        assert!(error.contains("[3, 2], not rows of 3"), "{error}");
        // The same in single precision.
        let text = b"'descr': '<f8'";
        let at = bytes.windows(text.len()).position(|w| w == text).unwrap();
        let mut single = bytes[..end - 48].to_vec();
        single[at + 12] = b'4';
        for x in [1.5f32, -2.0, 0.25, 4.0, 5.0, 6.0] {
            single.extend(x.to_le_bytes());
        }
        fs::write(&path, single).unwrap();
        let read = load_rows::<3>(&path).unwrap();
        assert_eq!(read, [[1.5, -2.0, 0.25], [4.0, 5.0, 6.0]]);
    }
}
