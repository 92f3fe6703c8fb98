//! Writing a file as a whole or not at all: under a temporary name in the same folder, renamed when it is complete.

use std::{
    fs::{self, File, OpenOptions},
    io::{self, BufWriter, Write},
    path::{Path, PathBuf},
    process,
    sync::atomic::{AtomicU64, Ordering},
};

use crate::{Error, Result};

/// Writes a file through `content`; where that or the system fails, `path` stays as it was and nothing is left behind.
///
/// A path that exists and is no regular file (a pipe, `/dev/stdout`) is written to directly; a link is followed.
///
/// # Errors
/// [`Error::File`] naming `path`, for instance where the disk is full.
pub fn write_atomic(
    path: &Path,
    content: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> Result<()> {
    write(path, content).map_err(|source| Error::file(path, source))
}

fn write(path: &Path, content: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> io::Result<()> {
    let target = match path.metadata() {
        Ok(found) if found.is_dir() => return Err(io::Error::other("is a folder")),
        Ok(found) if found.is_file() => path.canonicalize()?,
        Ok(_) => return fill(OpenOptions::new().write(true).open(path)?, content).map(drop),
        Err(_) => path.to_owned(),
    };
    let temporary = Temporary::beside(&target)?;
    let file = fill(temporary.open()?, content)?;
    // A full disk may tell only now; renaming before would put an incomplete file in place.
    file.sync_data()?;
    drop(file);
    temporary.rename(&target)
}

fn fill(file: File, content: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> io::Result<File> {
    let mut buffered = BufWriter::with_capacity(1 << 16, file);
    content(&mut buffered)?;
    buffered
        .into_inner()
        .map_err(io::IntoInnerError::into_error)
}

/// A file that is removed when dropped, unless it was renamed.
struct Temporary {
    path: PathBuf,
    renamed: bool,
}

impl Temporary {
    /// Picks a name beside `target` that no other thread or process picks.
    fn beside(target: &Path) -> io::Result<Self> {
        static COUNT: AtomicU64 = AtomicU64::new(0);
        let name = target
            .file_name()
            .ok_or_else(|| io::Error::other("names no file"))?;
        let number = COUNT.fetch_add(1, Ordering::Relaxed);
        let mut temporary = std::ffi::OsString::from(".");
        temporary.push(name);
        temporary.push(format!(".{}-{number}.tmp", process::id()));
        Ok(Self {
            path: target.with_file_name(temporary),
            renamed: false,
        })
    }

    fn open(&self) -> io::Result<File> {
        File::create(&self.path)
    }

    fn rename(mut self, target: &Path) -> io::Result<()> {
        fs::rename(&self.path, target)?;
        self.renamed = true;
        Ok(())
    }
}

impl Drop for Temporary {
    fn drop(&mut self) {
        if !self.renamed {
            // It may never have come into being; there is nothing to do about a failure either.
            let _ = fs::remove_file(&self.path);
        }
    }
}
