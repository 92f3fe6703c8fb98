//! One deformed frame as PLY or OBJ.

use std::{
    io::{self, Write},
    path::Path,
};

use glam::Vec3;

use super::write_atomic;
use crate::{Error, Result};

/// A deformed frame, a row a vertex in the input file's order.
#[derive(Clone, Copy, Debug)]
pub struct PlyFrame<'a> {
    /// Positions, model space.
    pub positions: &'a [Vec3],
    /// Unit normals, model space.
    pub normals: &'a [Vec3],
    /// Value of the composed field at each vertex.
    pub field: &'a [f32],
    /// Iso-value that each vertex keeps.
    pub iso: &'a [f32],
    /// 0 untouched, 1 on its iso-value, 2 stopped in contact, 3 outside every field, 4 iteration limit or, in tracking, on its way,
    /// 5 past the limit of its spine's map.
    pub state: &'a [u8],
    /// Joint row whose part each vertex belongs to.
    pub bone: &'a [u16],
    /// Triangles as vertex rows.
    pub triangles: &'a [[u32; 3]],
    /// Deformation method, for the comment.
    pub method: &'a str,
    /// Clip, for the comment.
    pub clip: &'a str,
    /// Time in the clip, seconds.
    pub time: f32,
    /// Name of the device, for the comment.
    pub device: &'a str,
}

/// Bytes of a vertex in the file: eight floats, a byte, a half-word.
const VERTEX: usize = 8 * 4 + 1 + 2;

/// Writes binary little-endian PLY: `x y z nx ny nz field iso` (float), `state` (uchar), `bone` (ushort) and faces.
///
/// # Errors
/// [`Error::Argument`] where the arrays differ in length; [`Error::File`] where the file cannot be written.
pub fn write_ply(path: &Path, frame: &PlyFrame<'_>) -> Result<()> {
    let count = frame.positions.len();
    let lengths = [
        ("normals", frame.normals.len()),
        ("field", frame.field.len()),
        ("iso", frame.iso.len()),
        ("state", frame.state.len()),
        ("bone", frame.bone.len()),
    ];
    for (name, length) in lengths {
        check_length(name, length, count)?;
    }
    write_atomic(path, |file| {
        file.write_all(ply_header(frame).as_bytes())?;
        for row in 0..count {
            file.write_all(&ply_vertex(frame, row))?;
        }
        for triangle in frame.triangles {
            let mut bytes = [3; 13];
            bytes[1..].copy_from_slice(bytemuck::bytes_of(&triangle.map(u32::to_le)));
            file.write_all(&bytes)?;
        }
        Ok(())
    })
}

fn check_length(name: &str, length: usize, count: usize) -> Result<()> {
    if length == count {
        return Ok(());
    }
    Err(Error::argument(
        name,
        format!("{length} rows for {count} positions"),
    ))
}

fn ply_header(frame: &PlyFrame<'_>) -> String {
    let mut header = format!(
        "ply\nformat binary_little_endian 1.0\ncomment {}\nelement vertex {}\n",
        comment(frame),
        frame.positions.len()
    );
    for name in ["x", "y", "z", "nx", "ny", "nz", "field", "iso"] {
        header += &format!("property float {name}\n");
    }
    header += "property uchar state\nproperty ushort bone\n";
    header += &format!("element face {}\n", frame.triangles.len());
    header + "property list uchar int vertex_indices\nend_header\n"
}

/// One line, whatever the names hold.
fn comment(frame: &PlyFrame<'_>) -> String {
    let line = format!(
        "dermis method={} clip={} time={} device={}",
        frame.method, frame.clip, frame.time, frame.device
    );
    line.replace(char::is_control, " ")
}

fn ply_vertex(frame: &PlyFrame<'_>, row: usize) -> [u8; VERTEX] {
    let (p, n) = (frame.positions[row], frame.normals[row]);
    let floats = [
        p.x,
        p.y,
        p.z,
        n.x,
        n.y,
        n.z,
        frame.field[row],
        frame.iso[row],
    ];
    let mut bytes = [0; VERTEX];
    for (place, value) in bytes.chunks_exact_mut(4).zip(floats) {
        place.copy_from_slice(&value.to_le_bytes());
    }
    bytes[32] = frame.state[row];
    bytes[33..].copy_from_slice(&frame.bone[row].to_le_bytes());
    bytes
}

/// Writes positions, normals and triangles as Wavefront OBJ.
///
/// # Errors
/// As [`write_ply`].
pub fn write_obj(path: &Path, frame: &PlyFrame<'_>) -> Result<()> {
    check_length("normals", frame.normals.len(), frame.positions.len())?;
    write_atomic(path, |file| {
        writeln!(file, "# {}", comment(frame))?;
        write_rows(file, "v", frame.positions)?;
        write_rows(file, "vn", frame.normals)?;
        for triangle in frame.triangles {
            let [a, b, c] = triangle.map(|row| u64::from(row) + 1);
            writeln!(file, "f {a}//{a} {b}//{b} {c}//{c}")?;
        }
        Ok(())
    })
}

fn write_rows(file: &mut dyn Write, keyword: &str, rows: &[Vec3]) -> io::Result<()> {
    for row in rows {
        writeln!(file, "{keyword} {} {} {}", row.x, row.y, row.z)?;
    }
    Ok(())
}
