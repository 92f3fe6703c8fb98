//! The file itself: reading it with a limit, telling GLB from JSON, splitting GLB into its chunks (glTF 2.0, chapter 4).

use std::{
    fs::File,
    io::{self, Read},
    path::Path,
};

use super::fault::{Checked, Fault, refuse};

/// Greatest size of a file that is read, bytes.
pub(super) const FILE_LIMIT: u64 = 1 << 30;

const MAGIC: &[u8; 4] = b"glTF";
const JSON: u32 = 0x4E4F_534A;
const BIN: u32 = 0x004E_4942;

/// The two parts of a glTF file.
#[derive(Debug)]
pub(super) struct Container<'a> {
    pub(super) json: &'a [u8],
    /// Whether it is a GLB.
    pub(super) is_glb: bool,
    /// The BIN chunk of a GLB.
    pub(super) binary: Option<&'a [u8]>,
}

/// Reads a regular file of at most [`FILE_LIMIT`] bytes.
pub(super) fn read(path: &Path) -> io::Result<Vec<u8>> {
    if !path.metadata()?.is_file() {
        return Err(io::Error::other("not a regular file"));
    }
    let mut bytes = Vec::new();
    File::open(path)?
        .take(FILE_LIMIT + 1)
        .read_to_end(&mut bytes)?;
    if bytes.len() as u64 > FILE_LIMIT {
        return Err(io::Error::other(format!(
            "larger than {} MiB",
            FILE_LIMIT >> 20
        )));
    }
    Ok(bytes)
}

/// Splits a GLB; anything else is taken for JSON.
pub(super) fn split(bytes: &[u8]) -> Checked<Container<'_>> {
    if bytes.starts_with(MAGIC) {
        return split_glb(bytes);
    }
    match bytes.iter().find(|byte| !byte.is_ascii_whitespace()) {
        Some(b'{') => Ok(Container {
            json: bytes,
            is_glb: false,
            binary: None,
        }),
        Some(_) => refuse("/", "neither a GLB nor a JSON object"),
        None => refuse("/", "the file is empty"),
    }
}

fn split_glb(bytes: &[u8]) -> Checked<Container<'_>> {
    const HEADER: &str = "GLB header";
    let (Some(version), Some(length)) = (word(bytes, 4), word(bytes, 8)) else {
        return refuse(HEADER, "the file ends inside the header");
    };
    if version != 2 {
        return refuse(HEADER, format!("version {version}, only 2 is known"));
    }
    let length = length as usize;
    let Some(mut rest) = bytes.get(12..length) else {
        let reason = format!("says {length} bytes, the file has {}", bytes.len());
        return refuse(HEADER, reason);
    };
    let mut chunks = Vec::new();
    while !rest.is_empty() {
        let (kind, data, after) = chunk(rest, chunks.len())?;
        chunks.push((kind, data));
        rest = after;
    }
    let Some(&(JSON, json)) = chunks.first() else {
        return refuse("GLB chunk 0", "the first chunk must be JSON");
    };
    if let Some(number) = (1..chunks.len()).find(|&i| chunks[i].0 == JSON) {
        return refuse(format!("GLB chunk {number}"), "a second JSON chunk");
    }
    let binaries: Vec<usize> = (1..chunks.len()).filter(|&i| chunks[i].0 == BIN).collect();
    let binary = match binaries[..] {
        [] => None,
        [1] => Some(chunks[1].1),
        [.., last] => {
            let element = format!("GLB chunk {last}");
            return refuse(element, "only chunk 1 may hold binary data");
        }
    };
    Ok(Container {
        json,
        is_glb: true,
        binary,
    })
}

/// Kind and data of the chunk at the start of `bytes`, and what follows it.
fn chunk(bytes: &[u8], number: usize) -> Checked<(u32, &[u8], &[u8])> {
    let element = || format!("GLB chunk {number}");
    let (Some(length), Some(kind)) = (word(bytes, 0), word(bytes, 4)) else {
        return refuse(element(), "the file ends inside the chunk's header");
    };
    let length = length as usize;
    if !length.is_multiple_of(4) {
        return refuse(element(), "its length is not a multiple of 4");
    }
    let end = length
        .checked_add(8)
        .filter(|&end| end <= bytes.len())
        .ok_or_else(|| Fault::new(element(), "passes the end of the file"))?;
    Ok((kind, &bytes[8..end], &bytes[end..]))
}

/// Little-endian word at `offset`.
fn word(bytes: &[u8], offset: usize) -> Option<u32> {
    let bytes = bytes.get(offset..offset + 4)?;
    Some(u32::from_le_bytes(bytes.try_into().ok()?))
}
