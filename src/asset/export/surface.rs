//! One mesh as PLY, OBJ or OFF.

use std::{io, path::Path};

use glam::Vec3;

use super::write_atomic;
use crate::{Error, Result};

/// A file format of meshes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SurfaceFormat {
    /// Wavefront OBJ: positions, normals, faces.
    Obj,
    /// Binary little-endian PLY: positions, normals, columns of your own, faces.
    Ply,
    /// OFF: positions and faces.
    Off,
}

impl SurfaceFormat {
    /// That which a file's ending names.
    pub fn of(path: &Path) -> Option<Self> {
        let extension = path.extension()?.to_str()?.to_ascii_lowercase();
        match extension.as_str() {
            "obj" => Some(Self::Obj),
            "ply" => Some(Self::Ply),
            "off" => Some(Self::Off),
            _ => None,
        }
    }
}

/// A mesh to write, a row a vertex in the input file's order.
#[derive(Clone, Copy, Debug)]
pub struct SurfaceFrame<'a> {
    /// Positions.
    pub positions: &'a [Vec3],
    /// Unit normals.
    pub normals: &'a [Vec3],
    /// Triangles as vertex rows.
    pub triangles: &'a [[u32; 3]],
    /// One line of text.
    pub comment: &'a str,
    /// More columns of a PLY, by name.
    pub columns: &'a [(&'a str, &'a [f32])],
}

/// Writes a mesh.
///
/// # Errors
/// [`Error::Argument`] where arrays differ in length; [`Error::File`] where the file cannot be written.
pub fn write_surface(path: &Path, format: SurfaceFormat, frame: &SurfaceFrame<'_>) -> Result<()> {
    let count = frame.positions.len();
    let columns = frame.columns.iter().map(|(name, rows)| (*name, rows.len()));
    for (name, length) in columns.chain([("normals", frame.normals.len())]) {
        if length != count {
            let reason = format!("{length} rows for {count} positions");
            return Err(Error::argument(name, reason));
        }
    }
    let comment = frame.comment.replace(char::is_control, " ");
    write_atomic(path, |file| match format {
        SurfaceFormat::Obj => obj(file, frame, &comment),
        SurfaceFormat::Ply => ply(file, frame, &comment),
        SurfaceFormat::Off => off(file, frame, &comment),
    })
}

fn obj(file: &mut dyn io::Write, frame: &SurfaceFrame<'_>, comment: &str) -> io::Result<()> {
    writeln!(file, "# {comment}")?;
    for p in frame.positions {
        writeln!(file, "v {} {} {}", p.x, p.y, p.z)?;
    }
    for n in frame.normals {
        writeln!(file, "vn {} {} {}", n.x, n.y, n.z)?;
    }
    for triangle in frame.triangles {
        let [a, b, c] = triangle.map(|row| u64::from(row) + 1);
        writeln!(file, "f {a}//{a} {b}//{b} {c}//{c}")?;
    }
    Ok(())
}

fn off(file: &mut dyn io::Write, frame: &SurfaceFrame<'_>, comment: &str) -> io::Result<()> {
    let (vertices, triangles) = (frame.positions.len(), frame.triangles.len());
    writeln!(file, "OFF\n# {comment}\n{vertices} {triangles} 0")?;
    for p in frame.positions {
        writeln!(file, "{} {} {}", p.x, p.y, p.z)?;
    }
    for [a, b, c] in frame.triangles {
        writeln!(file, "3 {a} {b} {c}")?;
    }
    Ok(())
}

fn ply(file: &mut dyn io::Write, frame: &SurfaceFrame<'_>, comment: &str) -> io::Result<()> {
    writeln!(
        file,
        "ply\nformat binary_little_endian 1.0\ncomment {comment}"
    )?;
    writeln!(file, "element vertex {}", frame.positions.len())?;
    let own = ["x", "y", "z", "nx", "ny", "nz"];
    for name in own.iter().chain(frame.columns.iter().map(|(name, _)| name)) {
        writeln!(file, "property float {name}")?;
    }
    writeln!(file, "element face {}", frame.triangles.len())?;
    writeln!(file, "property list uchar int vertex_indices\nend_header")?;
    for (row, (p, n)) in frame.positions.iter().zip(frame.normals).enumerate() {
        let columns = frame.columns.iter().map(|(_, rows)| rows[row]);
        for value in p.to_array().into_iter().chain(n.to_array()).chain(columns) {
            file.write_all(&value.to_le_bytes())?;
        }
    }
    for triangle in frame.triangles {
        file.write_all(&[3])?;
        for row in triangle {
            file.write_all(&row.to_le_bytes())?;
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::asset::load_surface;

    #[test]
    fn what_is_written_is_read_back() {
        let folder = tempfile::tempdir().unwrap();
        let positions = [Vec3::ZERO, Vec3::new(1.5, 0.1, -3e-9), Vec3::Y];
        let frame = SurfaceFrame {
            positions: &positions,
            normals: &[Vec3::Z; 3],
            triangles: &[[0, 1, 2], [2, 1, 0]],
            comment: "two\nsides",
            columns: &[("limit", &[1.0, f32::INFINITY, -2.0])],
        };
        for name in ["a.obj", "a.PLY", "a.off"] {
            let path = folder.path().join(name);
            write_surface(&path, SurfaceFormat::of(&path).unwrap(), &frame).unwrap();
            let read = load_surface(&path).unwrap();
            assert_eq!(read.positions, positions, "{name}");
            assert_eq!(read.triangles, frame.triangles, "{name}");
        }
        assert_eq!(SurfaceFormat::of(Path::new("a.stl")), None);
        let short = SurfaceFrame {
            normals: &[],
            ..frame
        };
        let error = write_surface(Path::new("x.obj"), SurfaceFormat::Obj, &short).unwrap_err();
        assert!(error.to_string().starts_with("normals: 0 rows"));
    }
}
