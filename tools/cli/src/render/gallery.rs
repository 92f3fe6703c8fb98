//! Where pictures go: one file with a sheet of them all, or a folder with a file a shot.

use std::{
    fs,
    path::{Path, PathBuf},
};

use dermis::{
    Error, Result,
    render::{Picture, sheet},
};

use crate::{
    output::{Partial, frame_name},
    png,
};

/// A picture with its label.
pub(crate) type Tile = (String, Picture);

/// Pictures on their way to disk; nothing is left of them unless [`Gallery::close`] is reached.
pub(crate) struct Gallery {
    output: PathBuf,
    partial: Partial,
    folder: bool,
    /// Shots so far; those of a folder are written at once and only counted.
    shots: usize,
    /// Rows of a sheet that one shot fills.
    rows: usize,
    tiles: Vec<Tile>,
}

impl Gallery {
    /// Makes sure that `output`, a PNG file or a folder, can be written.
    pub(crate) fn open(output: &Path, force: bool) -> Result<Self> {
        let extension = output.extension().and_then(|e| e.to_str());
        let folder = match extension {
            Some(e) if e.eq_ignore_ascii_case("png") => false,
            Some("jpg" | "jpeg" | "gif" | "mp4" | "webp") => {
                let reason = "give a .png file, or a folder, which gets a .png a frame";
                return Err(Error::argument("--output", reason));
            }
            _ => true,
        };
        Ok(Self {
            partial: match folder {
                true => Partial::folder(output, force)?,
                false => Partial::file(output)?,
            },
            output: output.into(),
            folder,
            shots: 0,
            rows: 1,
            tiles: Vec::new(),
        })
    }

    /// Every shot is a file of its own.
    pub(crate) fn is_folder(&self) -> bool {
        self.folder
    }

    /// The same, with this many rows a shot in a sheet.
    pub(crate) fn with_rows(self, rows: usize) -> Self {
        Self { rows, ..self }
    }

    /// Takes one shot's pictures, a method each.
    pub(crate) fn add(&mut self, tiles: Vec<Tile>) -> Result<()> {
        if self.folder {
            let path = self.partial.path().join(frame_name(self.shots, "png"));
            self.write(&path, &arranged(tiles, self.rows))?;
        } else {
            self.tiles.extend(tiles);
        }
        self.shots += 1;
        Ok(())
    }

    /// Puts the complete output in its place.
    pub(crate) fn close(mut self) -> Result<()> {
        if !self.folder {
            let rows = self.shots * self.rows;
            let picture = arranged(std::mem::take(&mut self.tiles), rows);
            self.write(self.partial.path(), &picture)?;
        }
        self.partial.keep()
    }

    fn write(&self, path: &Path, picture: &Picture) -> Result<()> {
        let bytes = png::encode(&self.output, picture)?;
        fs::write(path, bytes).map_err(|e| Error::file(&self.output, e))
    }
}

/// One picture as it is; several as a sheet with so many rows, or nearly square where a row is one picture.
fn arranged(mut tiles: Vec<Tile>, rows: usize) -> Picture {
    let columns = tiles.len() / rows.max(1);
    match (tiles.len(), columns) {
        (1, _) => tiles.swap_remove(0).1,
        (count, 0 | 1) => sheet(&tiles, count.isqrt().max(1) + 1),
        _ => sheet(&tiles, columns),
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn tiles(count: usize) -> Vec<Tile> {
        let tile = |i: usize| (format!("{i}"), Picture::filled(40, 40, [i as u8; 3]));
        (0..count).map(tile).collect()
    }

    #[test]
    fn one_picture_is_written_as_it_is_and_several_as_a_sheet() {
        let root = tempfile::tempdir().unwrap();
        for (count, wide) in [(1, false), (3, true)] {
            let path = root.path().join("out.png");
            let mut gallery = Gallery::open(&path, false).unwrap();
            gallery.add(tiles(count)).unwrap();
            gallery.close().unwrap();
            let bytes = std::io::Cursor::new(fs::read(&path).unwrap());
            let reader = ::png::Decoder::new(bytes).read_info().unwrap();
            assert_eq!(reader.info().width > 3 * 40, wide);
        }
    }

    #[test]
    fn a_folder_gets_a_file_a_shot_and_nothing_before_it_is_closed() {
        let root = tempfile::tempdir().unwrap();
        let path = root.path().join("frames");
        let mut gallery = Gallery::open(&path, false).unwrap();
        gallery.add(tiles(2)).unwrap();
        gallery.add(tiles(2)).unwrap();
        assert!(!path.exists());
        gallery.close().unwrap();
        let mut names: Vec<_> = fs::read_dir(&path)
            .unwrap()
            .map(|e| e.unwrap().file_name())
            .collect();
        names.sort();
        assert_eq!(names, ["frame_0000.png", "frame_0001.png"]);
    }

    #[test]
    fn a_dropped_gallery_leaves_nothing() {
        let root = tempfile::tempdir().unwrap();
        let mut gallery = Gallery::open(&root.path().join("out.png"), false).unwrap();
        gallery.add(tiles(1)).unwrap();
        drop(gallery);
        assert_eq!(fs::read_dir(root.path()).unwrap().count(), 0);
        assert!(Gallery::open(&root.path().join("out.gif"), false).is_err());
    }
}
