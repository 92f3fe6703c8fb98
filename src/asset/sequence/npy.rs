//! Arrays of NumPy: version 1 to 3, little-endian floats in C order, `[frame][vertex][3]`.

use std::{
    fs::File,
    io::{BufReader, Read, Seek, SeekFrom},
    path::Path,
};

use glam::Vec3;

use super::ROW_LIMIT;
use crate::{Error, Result};

/// What the file says before its numbers.
#[derive(Debug)]
pub(super) struct Head {
    pub(super) shape: [usize; 3],
    /// Where the numbers begin.
    start: u64,
}

impl Head {
    /// Reads the head and checks the file's length against it.
    pub(super) fn read(path: &Path) -> Result<Self> {
        let system = |e| Error::file(path, e);
        let mut file = File::open(path).map_err(system)?;
        let length = file.metadata().map_err(system)?.len();
        let mut bytes = Vec::new();
        file.by_ref()
            .take(1 << 16)
            .read_to_end(&mut bytes)
            .map_err(system)?;
        let head = parse(&bytes).map_err(|reason| Error::asset(path, "header", reason))?;
        let [frames, vertices, _] = head.shape;
        let wanted = frames as u128 * vertices as u128 * 12 + u128::from(head.start);
        if wanted != u128::from(length) {
            let reason = format!(
                "shape {:?} makes {wanted} bytes, the file has {length}",
                head.shape
            );
            return Err(Error::asset(path, "shape", reason));
        }
        Ok(head)
    }

    /// Reads the numbers, frame by frame.
    pub(super) fn frames(&self, path: &Path) -> Result<Vec<Vec<Vec3>>> {
        let system = |e| Error::file(path, e);
        let mut file = BufReader::new(File::open(path).map_err(system)?);
        file.seek(SeekFrom::Start(self.start)).map_err(system)?;
        let [frames, vertices, _] = self.shape;
        let mut bytes = vec![0; vertices * 12];
        let mut all = Vec::with_capacity(frames);
        for frame in 0..frames {
            file.read_exact(&mut bytes).map_err(system)?;
            let numbers = bytes.as_chunks::<4>().0.as_chunks::<3>().0;
            let row = |xyz: &[[u8; 4]; 3]| Vec3::from(xyz.map(f32::from_le_bytes));
            let rows: Vec<Vec3> = numbers.iter().map(row).collect();
            if let Some(vertex) = rows.iter().position(|p| !p.is_finite()) {
                let element = format!("frame {frame}, vertex {vertex}");
                return Err(Error::asset(path, element, "its position is not finite"));
            }
            all.push(rows);
        }
        Ok(all)
    }
}

/// The head, or what is wrong with it.
fn parse(bytes: &[u8]) -> Result<Head, String> {
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
    if !kind.starts_with("'<f4'") {
        return Err(format!("numbers of another kind than '<f4': {kind}"));
    }
    if !value(&text, "fortran_order").is_some_and(|v| v.starts_with("False")) {
        return Err("the array is not in C order".into());
    }
    let shape = value(&text, "shape").and_then(|v| v.strip_prefix('(')?.split_once(')'));
    let (shape, _) = shape.ok_or("no shape")?;
    let sizes = shape.split(',').map(str::trim).filter(|w| !w.is_empty());
    let sizes: Option<Vec<usize>> = sizes.map(|w| w.parse().ok()).collect();
    match sizes.as_deref() {
        Some(&[frames, vertices, 3]) if frames > 0 && vertices > 0 && vertices <= ROW_LIMIT => {
            Ok(Head {
                shape: [frames, vertices, 3],
                start: (at + size) as u64,
            })
        }
        _ => Err(format!("shape ({shape}), not (frames, vertices, 3)")),
    }
}

/// What follows a key of the head's dictionary.
fn value<'a>(text: &'a str, key: &str) -> Option<&'a str> {
    let (_, rest) = text.split_once(&format!("'{key}'"))?;
    Some(rest.trim_start().strip_prefix(':')?.trim_start())
}
