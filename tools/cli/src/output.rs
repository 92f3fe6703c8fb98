//! Output that is complete or absent: written under a temporary name beside its place, then renamed.

use std::{
    fs, io,
    path::{Path, PathBuf},
};

use dermis::{Error, Result};

/// A temporary file or folder beside `target`; removed when dropped before [`Partial::keep`].
#[derive(Debug)]
pub(crate) struct Partial {
    target: PathBuf,
    path: PathBuf,
    kept: bool,
}

impl Partial {
    /// A file that will be `target`; created at once, so that an unwritable place is found before the work.
    pub(crate) fn file(target: &Path) -> Result<Self> {
        if target.is_dir() {
            return Err(Error::file(target, io::ErrorKind::IsADirectory.into()));
        }
        let path = beside(target)?;
        fs::File::create_new(&path).map_err(|e| Error::file(target, e))?;
        Ok(Self::new(target, path))
    }

    /// A folder that will be `target`, which must not exist or be empty, unless `force` lets its frames be replaced.
    pub(crate) fn folder(target: &Path, force: bool) -> Result<Self> {
        match fs::read_dir(target) {
            Ok(mut entries) => {
                if !force && entries.next().is_some() {
                    let reason = "the folder is not empty; --force replaces its frames";
                    return Err(Error::asset(target, "output", reason));
                }
            }
            Err(e) if e.kind() == io::ErrorKind::NotFound => {}
            Err(e) => return Err(Error::file(target, e)),
        }
        let path = beside(target)?;
        fs::create_dir(&path).map_err(|e| Error::file(target, e))?;
        Ok(Self::new(target, path))
    }

    fn new(target: &Path, path: PathBuf) -> Self {
        Self {
            target: target.into(),
            path,
            kept: false,
        }
    }

    /// Where to write.
    pub(crate) fn path(&self) -> &Path {
        &self.path
    }

    /// An error of writing, about the final place instead of the temporary one.
    pub(crate) fn blame(&self, error: Error) -> Error {
        match error {
            Error::File { path, source } => match path.strip_prefix(&self.path) {
                Ok(rest) if rest.as_os_str().is_empty() => Error::file(&self.target, source),
                Ok(rest) => Error::file(self.target.join(rest), source),
                Err(_) => Error::file(path, source),
            },
            other => other,
        }
    }

    /// Puts the complete output in its place. Files of a folder that are not frames stay as they are.
    pub(crate) fn keep(mut self) -> Result<()> {
        let failed = |e| Error::file(&self.target, e);
        if self.path.is_dir() && holds_something(&self.target) {
            replace_frames(&self.path, &self.target).map_err(failed)?;
        } else {
            fs::rename(&self.path, &self.target).map_err(failed)?;
            self.kept = true;
        }
        Ok(())
    }
}

impl Drop for Partial {
    fn drop(&mut self) {
        if self.kept {
            return;
        }
        // Nothing can be done about a failure here: the temporary name says what is left.
        let _ = match self.path.is_dir() {
            true => fs::remove_dir_all(&self.path),
            false => fs::remove_file(&self.path),
        };
    }
}

/// Name of frame `number` in a folder.
pub(crate) fn frame_name(number: usize, extension: &str) -> String {
    format!("frame_{number:04}.{extension}")
}

fn beside(target: &Path) -> Result<PathBuf> {
    let name = target
        .file_name()
        .ok_or_else(|| Error::argument("--output", format!("{} has no name", target.display())))?;
    let mut partial = std::ffi::OsString::from(".");
    partial.push(name);
    partial.push(format!(".partial-{}", std::process::id()));
    Ok(target.with_file_name(partial))
}

fn holds_something(folder: &Path) -> bool {
    fs::read_dir(folder).is_ok_and(|mut entries| entries.next().is_some())
}

/// Moves the new frames in, after the frames of an earlier run are gone.
fn replace_frames(from: &Path, to: &Path) -> io::Result<()> {
    for entry in fs::read_dir(to)? {
        let entry = entry?;
        if is_frame(&entry.file_name().to_string_lossy()) {
            fs::remove_file(entry.path())?;
        }
    }
    for entry in fs::read_dir(from)? {
        let entry = entry?;
        fs::rename(entry.path(), to.join(entry.file_name()))?;
    }
    Ok(())
}

fn is_frame(name: &str) -> bool {
    let parts = name
        .strip_prefix("frame_")
        .and_then(|rest| rest.split_once('.'));
    parts.is_some_and(|(number, extension)| {
        number.len() >= 4
            && number.bytes().all(|b| b.is_ascii_digit())
            && matches!(extension, "ply" | "obj" | "png")
    })
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        let mut names: Vec<String> = fs::read_dir(folder)
            .unwrap()
            .map(|e| e.unwrap().file_name().into_string().unwrap())
            .collect();
        names.sort();
        names
    }

    #[test]
    fn a_dropped_folder_leaves_nothing() {
        let root = tempfile::tempdir().unwrap();
        let partial = Partial::folder(&root.path().join("out"), false).unwrap();
        fs::write(partial.path().join("frame_0000.ply"), "half").unwrap();
        drop(partial);
        assert!(names(root.path()).is_empty());
    }

    #[test]
    fn a_kept_folder_replaces_an_empty_one() {
        let root = tempfile::tempdir().unwrap();
        let out = root.path().join("out");
        fs::create_dir(&out).unwrap();
        let partial = Partial::folder(&out, false).unwrap();
        fs::write(partial.path().join("frame_0000.ply"), "whole").unwrap();
        partial.keep().unwrap();
        assert_eq!(names(root.path()), ["out"]);
        assert_eq!(names(&out), ["frame_0000.ply"]);
    }

    #[test]
    fn force_replaces_frames_and_keeps_other_files() {
        let root = tempfile::tempdir().unwrap();
        let out = root.path().join("out");
        fs::create_dir(&out).unwrap();
        for name in ["frame_0000.ply", "frame_0001.ply", "thesis.tex"] {
            fs::write(out.join(name), "old").unwrap();
        }
        assert!(Partial::folder(&out, false).is_err());
        let partial = Partial::folder(&out, true).unwrap();
        fs::write(partial.path().join("frame_0000.ply"), "new").unwrap();
        partial.keep().unwrap();
        assert_eq!(names(&out), ["frame_0000.ply", "thesis.tex"]);
        assert_eq!(
            fs::read_to_string(out.join("frame_0000.ply")).unwrap(),
            "new"
        );
        assert_eq!(names(root.path()), ["out"]);
    }

    #[test]
    fn an_unwritable_place_is_found_before_the_work() {
        let root = tempfile::tempdir().unwrap();
        let missing = root.path().join("missing").join("out.glb");
        let error = Partial::file(&missing).unwrap_err().to_string();
        assert!(error.contains("out.glb"), "{error}");
        assert!(Partial::file(root.path()).is_err());
        fs::write(root.path().join("file"), "").unwrap();
        assert!(Partial::folder(&root.path().join("file"), true).is_err());
    }
}
