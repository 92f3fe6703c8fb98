//! Captured animations in: a folder of meshes, a folder with `rest.obj` and `frames.npy`, or a single mesh.

#[cfg(test)]
mod tests;

use std::{
    cmp::Ordering,
    fs,
    io::Read,
    path::{Path, PathBuf},
};

use glam::Vec3;

use super::{
    ROW_LIMIT, Surface, is_surface, load_surface,
    npy::{Head, Kind},
};
use crate::{Error, Result};

/// The same mesh at several moments.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Sequence {
    /// Folder or file.
    pub path: PathBuf,
    /// Faces as vertex rows, the same in all frames.
    pub triangles: Vec<[u32; 3]>,
    /// Positions of all vertices, a row a frame; finite, at least one frame, all of the same length.
    pub frames: Vec<Vec<Vec3>>,
}

/// Memory that may be used, asked before a sequence is read.
#[derive(Clone, Copy, Debug)]
pub struct Room {
    /// Bytes there are.
    pub bytes: u64,
    /// Bytes that the work needs for one vertex in so many frames.
    pub need: fn(frames: usize) -> u64,
}

impl Room {
    /// What the system says is available; no limit where it does not say.
    pub fn available(need: fn(frames: usize) -> u64) -> Self {
        let text = fs::read_to_string("/proc/meminfo").unwrap_or_default();
        let line = text.lines().find_map(|l| l.strip_prefix("MemAvailable:"));
        let word = line.and_then(|l| l.split_ascii_whitespace().next());
        let kib: Option<u64> = word.and_then(|w| w.parse().ok());
        Self {
            bytes: kib.map_or(u64::MAX, |kib| kib * 1024),
            need,
        }
    }

    /// # Errors
    /// [`Error::Memory`] naming the sequence and both figures where it does not fit.
    pub fn check(&self, path: &Path, vertices: usize, frames: usize) -> Result<()> {
        let each = (self.need)(frames);
        let bytes = each.saturating_mul(vertices as u64);
        if bytes <= self.bytes {
            return Ok(());
        }
        Err(Error::Memory {
            name: path.display().to_string(),
            class: "sequence",
            bytes,
            reason: format!(
                "{vertices} vertices in {frames} frames at {each} bytes a vertex, but {} bytes are available",
                self.bytes
            ),
        })
    }
}

/// Reads a sequence: a folder with `rest.obj` (or `.ply`, `.off`) and `frames.npy` (NumPy, `<f4`, C order,
/// `[frame][vertex][3]`), a folder with a mesh a frame in the order of their names (numbers by their value), or one mesh.
///
/// # Errors
/// As [`load_surface`], and [`Error::Asset`] naming the file where a frame has other vertices or faces than the first;
/// [`Error::Memory`] where the sequence needs more than `room`, before it is read.
pub fn load_sequence(path: &Path, room: Room) -> Result<Sequence> {
    if !path.is_dir() {
        return meshes(path, &[path.to_owned()], room);
    }
    let array = path.join("frames.npy");
    if array.symlink_metadata().is_ok() {
        whole(&array)?;
        return array_of(path, &array, room);
    }
    let mut files = Vec::new();
    for entry in fs::read_dir(path).map_err(|e| Error::file(path, e))? {
        let file = entry.map_err(|e| Error::file(path, e))?.path();
        if is_surface(&file) {
            whole(&file)?;
            files.push(file);
        }
    }
    if files.is_empty() {
        let reason = "neither frames.npy nor any .obj, .ply or .off file";
        return Err(Error::asset(path, "folder", reason));
    }
    files.sort_by(|a, b| natural(&a.to_string_lossy(), &b.to_string_lossy()));
    meshes(path, &files, room)
}

/// A frame that cannot be read must not be missing without a word: what is named like one has to be a file.
fn whole(path: &Path) -> Result<()> {
    let found = fs::metadata(path).map_err(|e| Error::file(path, e))?;
    if found.is_file() {
        return Ok(());
    }
    Err(Error::asset(path, "file", "it is a folder or a device"))
}

fn array_of(folder: &Path, array: &Path, room: Room) -> Result<Sequence> {
    let rest = ["rest.obj", "rest.ply", "rest.off"].map(|name| folder.join(name));
    let Some(rest) = rest.iter().find(|file| file.is_file()) else {
        let reason = "frames.npy without a rest.obj, rest.ply or rest.off that has the faces";
        return Err(Error::asset(folder, "folder", reason));
    };
    let head = Head::read(array, &[Kind::Single])?;
    let (count, vertices) = match head.shape[..] {
        [frames, vertices, 3] if frames > 0 && vertices > 0 && vertices <= ROW_LIMIT => {
            (frames, vertices)
        }
        _ => {
            let reason = format!("{:?}, not (frames, vertices, 3)", head.shape);
            return Err(Error::asset(array, "shape", reason));
        }
    };
    room.check(folder, vertices, count)?;
    let Surface {
        positions,
        triangles,
    } = load_surface(rest)?;
    if positions.len() != vertices {
        let reason = format!(
            "{vertices} vertices a frame, but {} has {}",
            rest.display(),
            positions.len()
        );
        return Err(Error::asset(array, "shape", reason));
    }
    Ok(Sequence {
        path: folder.to_owned(),
        triangles,
        frames: frames_of(&head, array, count, vertices)?,
    })
}

/// The array's numbers, frame by frame.
fn frames_of(head: &Head, path: &Path, count: usize, vertices: usize) -> Result<Vec<Vec<Vec3>>> {
    let mut file = head.numbers(path)?;
    let mut bytes = vec![0; vertices * 12];
    let mut all = Vec::with_capacity(count);
    for frame in 0..count {
        file.read_exact(&mut bytes)
            .map_err(|e| Error::file(path, e))?;
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

fn meshes(path: &Path, files: &[PathBuf], room: Room) -> Result<Sequence> {
    let (mut triangles, mut frames) = (Vec::new(), Vec::<Vec<Vec3>>::new());
    for file in files {
        let surface = load_surface(file)?;
        if let Some(first) = frames.first() {
            same(file, &surface, first.len(), &triangles)?;
        } else {
            room.check(path, surface.positions.len(), files.len())?;
            triangles = surface.triangles;
        }
        frames.push(surface.positions);
    }
    Ok(Sequence {
        path: path.to_owned(),
        triangles,
        frames,
    })
}

fn same(file: &Path, other: &Surface, vertices: usize, triangles: &[[u32; 3]]) -> Result<()> {
    let refuse = |element: String, reason| Err(Error::asset(file, element, reason));
    let count = other.positions.len();
    if count != vertices {
        let reason = format!("{count}, but the first frame has {vertices}");
        return refuse("vertices".into(), reason);
    }
    let count = other.triangles.len();
    if count != triangles.len() {
        let reason = format!("{count}, but the first frame has {}", triangles.len());
        return refuse("triangles".into(), reason);
    }
    let mut pairs = other.triangles.iter().zip(triangles);
    match pairs.position(|(a, b)| a != b) {
        None => Ok(()),
        Some(row) => {
            let (here, there) = (other.triangles[row], triangles[row]);
            let reason = format!("{here:?}, but {there:?} in the first frame");
            refuse(format!("triangle {row}"), reason)
        }
    }
}

/// Orders names by their letters and, where both have digits, by the numbers' values.
fn natural(a: &str, b: &str) -> Ordering {
    let (mut a, mut b) = (a, b);
    loop {
        let digits = |s: &str| s.bytes().take_while(u8::is_ascii_digit).count();
        let (da, db) = (digits(a), digits(b));
        if da > 0 && db > 0 {
            let (x, y) = (
                a[..da].trim_start_matches('0'),
                b[..db].trim_start_matches('0'),
            );
            let order = x.len().cmp(&y.len()).then_with(|| x.cmp(y));
            if order != Ordering::Equal {
                return order;
            }
            (a, b) = (&a[da..], &b[db..]);
            continue;
        }
        let (mut x, mut y) = (a.chars(), b.chars());
        match (x.next(), y.next()) {
            (Some(p), Some(q)) if p == q => (a, b) = (x.as_str(), y.as_str()),
            (p, q) => return p.cmp(&q),
        }
    }
}
