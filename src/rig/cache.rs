//! Files that keep the results of long preparation, keyed by content, checksummed, written atomically.

use std::{
    fs,
    io::{self, Write},
    path::{Path, PathBuf},
};

use crate::{Error, Result};

/// Opens every file; the last byte is the format's version.
const MAGIC: [u8; 8] = *b"DERMIS\x00\x01";
/// Magic, byte order mark, key, length, checksum.
const HEADER: usize = 8 + 4 + 16 + 8 + 8;
const BYTE_ORDER: u32 = 0x0102_0304;

/// What a cached entry is and what it was made of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Key {
    kind: &'static str,
    hash: u128,
}

/// Builds a [`Key`] from content: FNV-1a with 128 bits, against mix-ups, not against forgers.
#[derive(Clone, Debug)]
pub struct KeyBuilder(Key);

impl Key {
    /// A key of this kind (part of the file's name: letters, digits, `-`); this library's version is hashed first.
    pub fn builder(kind: &'static str) -> KeyBuilder {
        let hash = 0x6c62_272e_07bb_0142_62b8_2175_6295_c58d;
        KeyBuilder(Self { kind, hash }).text(env!("CARGO_PKG_VERSION"))
    }

    fn file(&self, dir: &Path) -> PathBuf {
        dir.join(format!("{}-{:032x}.dermis", self.kind, self.hash))
    }
}

impl KeyBuilder {
    /// Adds plain values and their count.
    pub fn pods<T: bytemuck::NoUninit>(self, values: &[T]) -> Self {
        self.bytes(&(values.len() as u64).to_le_bytes())
            .bytes(bytemuck::cast_slice(values))
    }

    /// Adds a text and its length.
    pub fn text(self, text: &str) -> Self {
        self.pods(text.as_bytes())
    }

    /// The key.
    pub fn finish(self) -> Key {
        self.0
    }

    fn bytes(mut self, bytes: &[u8]) -> Self {
        for byte in bytes {
            self.0.hash ^= u128::from(*byte);
            self.0.hash = self.0.hash.wrapping_mul(0x0100_0000_0000_0000_0000_013b);
        }
        self
    }
}

/// What [`load`] found.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Entry {
    /// The bytes that were stored.
    Found(Vec<u8>),
    /// No such entry.
    Absent,
    /// A file that cannot be trusted, and why; it is to be made anew.
    Refused(String),
}

/// Looks up an entry; never fails, for what cannot be read can be made anew.
pub fn load(dir: &Path, key: &Key) -> Entry {
    let path = key.file(dir);
    match fs::read(&path) {
        Ok(bytes) => match open(&bytes, key) {
            Ok(payload) => Entry::Found(payload.to_vec()),
            Err(reason) => Entry::Refused(format!("cache {}: {reason}", path.display())),
        },
        Err(e) if e.kind() == io::ErrorKind::NotFound => Entry::Absent,
        Err(e) => Entry::Refused(format!("cache {}: {e}", path.display())),
    }
}

/// Keeps an entry, making the folder where it is missing; the file appears whole or not at all.
///
/// # Errors
/// [`Error::File`] where the system refuses; nothing is left behind.
pub fn store(dir: &Path, key: &Key, payload: &[u8]) -> Result<()> {
    fs::create_dir_all(dir).map_err(|e| Error::file(dir, e))?;
    let path = key.file(dir);
    // Threads and processes may store the same entry at once.
    let thread = format!("{:?}", std::thread::current().id());
    let number: String = thread.chars().filter(char::is_ascii_digit).collect();
    let temporary = path.with_extension(format!("{}-{number}.tmp", std::process::id()));
    write(&temporary, key, payload)
        .and_then(|()| fs::rename(&temporary, &path))
        .map_err(|e| {
            let _ = fs::remove_file(&temporary);
            Error::file(path, e)
        })
}

fn write(path: &Path, key: &Key, payload: &[u8]) -> io::Result<()> {
    let mut file = fs::File::create(path)?;
    file.write_all(&header(key, payload))?;
    file.write_all(payload)?;
    file.sync_all()
}

fn header(key: &Key, payload: &[u8]) -> Vec<u8> {
    let mut header = Vec::with_capacity(HEADER);
    header.extend(MAGIC);
    header.extend(BYTE_ORDER.to_ne_bytes());
    header.extend(key.hash.to_le_bytes());
    header.extend((payload.len() as u64).to_le_bytes());
    header.extend(checksum(payload).to_le_bytes());
    header
}

/// The payload, or why it cannot be trusted.
fn open<'a>(bytes: &'a [u8], key: &Key) -> Result<&'a [u8], &'static str> {
    let (head, payload) = bytes.split_at_checked(HEADER).ok_or("it is too short")?;
    let wanted = header(key, payload);
    if head[..8] != wanted[..8] {
        return Err("it is not of this format");
    }
    if head[8..28] != wanted[8..28] {
        return Err("it belongs to other content");
    }
    if head != wanted {
        return Err("it is damaged");
    }
    Ok(payload)
}

/// FNV-1a with 64 bits.
fn checksum(bytes: &[u8]) -> u64 {
    bytes.iter().fold(0xcbf2_9ce4_8422_2325, |hash, byte| {
        (hash ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01b3)
    })
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn key(text: &str) -> Key {
        Key::builder("test").text(text).finish()
    }

    #[test]
    fn an_entry_comes_back_and_others_do_not() {
        let dir = tempfile::tempdir().unwrap();
        let dir = dir.path().join("made/on/demand");
        assert_eq!(load(&dir, &key("a")), Entry::Absent);
        store(&dir, &key("a"), b"payload").unwrap();
        store(&dir, &key("a"), b"payload").unwrap();
        assert_eq!(load(&dir, &key("a")), Entry::Found(b"payload".into()));
        assert_eq!(load(&dir, &key("b")), Entry::Absent);
        assert_eq!(fs::read_dir(&dir).unwrap().count(), 1, "left-overs");
    }

    #[test]
    fn every_damaged_byte_and_every_truncation_is_refused() {
        let dir = tempfile::tempdir().unwrap();
        let key = key("a");
        store(dir.path(), &key, b"payload").unwrap();
        let path = key.file(dir.path());
        let good = fs::read(&path).unwrap();
        for k in 0..good.len() {
            let mut bad = good.clone();
            bad[k] ^= 0x10;
            assert!(open(&bad, &key).is_err(), "byte {k}");
            assert!(open(&good[..k], &key).is_err(), "length {k}");
        }
        fs::write(&path, &good[..20]).unwrap();
        let Entry::Refused(reason) = load(dir.path(), &key) else {
            panic!("a truncated file was taken");
        };
        assert!(reason.contains("too short"));
    }

    #[test]
    fn a_stale_file_is_refused() {
        let dir = tempfile::tempdir().unwrap();
        store(dir.path(), &key("old"), b"payload").unwrap();
        fs::rename(key("old").file(dir.path()), key("new").file(dir.path())).unwrap();
        let entry = load(dir.path(), &key("new"));
        assert!(matches!(entry, Entry::Refused(r) if r.contains("other content")));
    }

    #[test]
    fn a_folder_that_cannot_be_made_is_an_error_naming_it() {
        let dir = tempfile::tempdir().unwrap();
        let file = dir.path().join("file");
        fs::write(&file, "").unwrap();
        let error = store(&file, &key("a"), b"").unwrap_err();
        assert!(error.to_string().contains("file"));
    }

    #[test]
    fn boundaries_between_values_count() {
        let a = Key::builder("k").text("ab").text("c").finish();
        let b = Key::builder("k").text("a").text("bc").finish();
        assert_ne!(a, b);
    }
}
