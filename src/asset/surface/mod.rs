//! Static meshes in: OBJ, PLY and OFF as positions and triangles, every refusal naming the line or the element.

mod gather;
mod obj;
mod off;
mod ply;
#[cfg(test)]
mod tests;
mod text;

use std::{fs, path::Path};

use glam::Vec3;

use crate::{Error, Result};

/// A static mesh: what its file says, row for row.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Surface {
    /// Positions in the file's order, finite; vertices without a face included.
    pub positions: Vec<Vec3>,
    /// Faces as vertex rows, in range; a face of more corners is a fan about its first.
    pub triangles: Vec<[u32; 3]>,
}

/// Element and reason, of a file that whoever holds the path will name.
type Parsed<T> = Result<T, (String, String)>;

type Parser = fn(&[u8]) -> Parsed<Surface>;

fn refuse<T>(element: impl Into<String>, reason: impl Into<String>) -> Parsed<T> {
    Err((element.into(), reason.into()))
}

/// Reads a mesh from an `.obj`, `.ply` (text or binary of either byte order) or `.off` file.
///
/// Positions and faces only: colours, normals, texture coordinates, lines and unknown elements are passed over. Triangles
/// that name a corner twice are kept, so that rows can be compared between files.
///
/// # Errors
/// [`Error::File`] where the file cannot be read; [`Error::Asset`] naming the line of a text file or the element of a
/// binary one: another ending, a number that is not finite, an index out of range, a file that ends early, no face at all,
/// or more than [`ROW_LIMIT`](super::ROW_LIMIT) rows.
pub fn load_surface(path: &Path) -> Result<Surface> {
    let parse = parser(path)?;
    let bytes = fs::read(path).map_err(|source| Error::file(path, source))?;
    parse(&bytes).map_err(|(element, reason)| Error::asset(path, element, reason))
}

/// Whether [`load_surface`] knows the file's ending.
pub fn is_surface(path: &Path) -> bool {
    parser(path).is_ok()
}

fn parser(path: &Path) -> Result<Parser> {
    let extension = path.extension().and_then(|e| e.to_str());
    match extension.map(str::to_ascii_lowercase).as_deref() {
        Some("obj") => Ok(obj::parse),
        Some("ply") => Ok(ply::parse),
        Some("off") => Ok(off::parse),
        _ => {
            let reason = "a mesh is an .obj, .ply or .off file";
            Err(Error::asset(path, "name", reason))
        }
    }
}
