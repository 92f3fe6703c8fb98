//! Hierarchies as files (`.dsm`): a head, the topology, the spheres; each part with its checksum, all little-endian.

use std::{
    fs,
    io::{self, Write},
    path::Path,
};

use glam::DVec3;

use super::hierarchy::{Hierarchy, Merge};
use crate::{Error, Result, asset::write_atomic};

/// Opens every file; the last byte is the format's version.
const MAGIC: [u8; 8] = *b"DERMSM\x00\x01";
/// Magic; five counts; origin, diagonal, weight; checksum.
const HEAD: usize = 8 + 5 * 8 + 5 * 8 + 8;
/// Children, radius, four bytes of nothing, total.
const MERGE: usize = 24;

/// Neither do builds take smaller diagonals, nor greater than the inverse.
const LEAST: f64 = 1e-30;
/// No coordinate or radius is so many diagonals: single precision would hold nothing of the shape there.
const GREATEST: f32 = 1e9;

/// Rows, vertices, triangles, collapses, frames.
type Counts = [usize; 5];

impl Hierarchy {
    /// Writes the hierarchy; the file appears whole or not at all.
    ///
    /// # Errors
    /// [`Error::File`] where the system refuses.
    pub fn save(&self, path: &Path) -> Result<()> {
        write_atomic(path, |out| {
            part(out, &self.head())?;
            part(out, &self.topology())?;
            let spheres: Vec<u8> = self.centres.iter().flat_map(|x| x.to_le_bytes()).collect();
            part(out, &spheres)
        })
    }

    /// Reads a hierarchy that [`Hierarchy::save`] wrote.
    ///
    /// # Errors
    /// [`Error::File`] where the system refuses; [`Error::Asset`] naming the part where the file is no such file, of another
    /// version, or damaged.
    pub fn load(path: &Path) -> Result<Self> {
        let bytes = fs::read(path).map_err(|e| Error::file(path, e))?;
        parse(&bytes).map_err(|(element, reason)| Error::asset(path, element, reason))
    }

    fn head(&self) -> Vec<u8> {
        let mut bytes = MAGIC.to_vec();
        let counts = [
            self.vertex.len(),
            self.vertices,
            self.triangles.len(),
            self.merges.len(),
            self.frames,
        ];
        bytes.extend(counts.iter().flat_map(|&n| (n as u64).to_le_bytes()));
        let [x, y, z] = self.origin.to_array();
        let numbers = [x, y, z, self.diagonal, self.weight];
        bytes.extend(numbers.iter().flat_map(|x| x.to_le_bytes()));
        bytes
    }

    fn topology(&self) -> Vec<u8> {
        let rows = self.vertex.iter().chain(self.triangles.iter().flatten());
        let mut bytes: Vec<u8> = rows.flat_map(|row| row.to_le_bytes()).collect();
        for merge in &self.merges {
            bytes.extend(merge.children.iter().flat_map(|c| c.to_le_bytes()));
            bytes.extend(merge.radius.to_le_bytes());
            bytes.extend([0; 4]);
            bytes.extend(merge.total.to_le_bytes());
        }
        bytes
    }
}

fn part(out: &mut dyn Write, bytes: &[u8]) -> io::Result<()> {
    out.write_all(bytes)?;
    out.write_all(&checksum(bytes).to_le_bytes())
}

/// FNV-1a over words: one changed word always changes it.
fn checksum(bytes: &[u8]) -> u64 {
    let step = |hash: u64, word: u64| (hash ^ word).wrapping_mul(0x0100_0000_01b3).rotate_left(23);
    let (words, rest) = bytes.as_chunks::<8>();
    let words = words.iter().map(|w| u64::from_le_bytes(*w));
    let hash = words.fold(0xcbf2_9ce4_8422_2325 ^ bytes.len() as u64, step);
    rest.iter()
        .fold(hash, |hash, &byte| step(hash, u64::from(byte)))
}

/// Element and reason.
type Parsed<T> = Result<T, (&'static str, String)>;

fn refuse<T>(element: &'static str, reason: impl Into<String>) -> Parsed<T> {
    Err((element, reason.into()))
}

/// Takes a part of `size` bytes and its checksum.
fn take<'a>(bytes: &mut &'a [u8], size: usize, name: &'static str) -> Parsed<&'a [u8]> {
    let Some((part, rest)) = bytes.split_at_checked(size) else {
        return refuse(name, "the file ends within it");
    };
    let Some((sum, rest)) = rest.split_first_chunk::<8>() else {
        return refuse(name, "the file ends within it");
    };
    if u64::from_le_bytes(*sum) != checksum(part) {
        return refuse(name, "it is damaged: its checksum is another");
    }
    *bytes = rest;
    Ok(part)
}

fn parse(mut bytes: &[u8]) -> Parsed<Hierarchy> {
    match bytes.get(..8) {
        Some(magic) if magic == MAGIC => {}
        Some(magic) if magic[..7] == MAGIC[..7] => {
            return refuse(
                "head",
                format!("version {} of the format is not known", magic[7]),
            );
        }
        _ => return refuse("head", "it is no sphere-mesh of dermis"),
    }
    let head = take(&mut bytes, HEAD - 8, "head")?;
    let words: Vec<u64> = head[8..]
        .as_chunks()
        .0
        .iter()
        .map(|w| u64::from_le_bytes(*w))
        .collect();
    let counts = counts(&words)?;
    let [rows, vertices, triangles, merges, frames] = counts;
    let (topology, spheres) =
        sizes(counts).ok_or(("head", "counts that fit no memory".to_owned()))?;
    let topology = take(&mut bytes, topology, "topology")?;
    let spheres = take(&mut bytes, spheres, "spheres")?;
    if !bytes.is_empty() {
        return refuse("end", format!("{} bytes too many", bytes.len()));
    }
    let (indices, tail) = topology.split_at((rows + 3 * triangles) * 4);
    let indices: Vec<u32> = indices
        .as_chunks()
        .0
        .iter()
        .map(|w| u32::from_le_bytes(*w))
        .collect();
    let (vertex, corners) = indices.split_at(rows);
    let real = |k: usize| f64::from_bits(words[5 + k]);
    let hierarchy = Hierarchy {
        vertex: vertex.to_vec(),
        triangles: corners.as_chunks::<3>().0.to_vec(),
        merges: tail.as_chunks().0.iter().map(merge).collect(),
        frames,
        vertices,
        origin: DVec3::new(real(0), real(1), real(2)),
        diagonal: real(3),
        weight: real(4),
        centres: spheres
            .as_chunks()
            .0
            .iter()
            .map(|w| f32::from_le_bytes(*w))
            .collect(),
    };
    debug_assert_eq!(hierarchy.merges.len(), merges);
    check(&hierarchy)?;
    Ok(hierarchy)
}

fn counts(words: &[u64]) -> Parsed<Counts> {
    let mut counts = [0; 5];
    for (count, word) in counts.iter_mut().zip(words) {
        *count = usize::try_from(*word).or_else(|_| refuse("head", "a count is out of range"))?;
    }
    let [_, vertices, _, merges, frames] = counts;
    if frames == 0 || merges >= vertices || vertices > u32::MAX as usize / 2 {
        return refuse("head", "its counts contradict each other");
    }
    Ok(counts)
}

/// Bytes of the topology and of the spheres.
fn sizes([rows, vertices, triangles, merges, frames]: Counts) -> Option<(usize, usize)> {
    let indices = triangles
        .checked_mul(3)?
        .checked_add(rows)?
        .checked_mul(4)?;
    let topology = merges.checked_mul(MERGE)?.checked_add(indices)?;
    let spheres = vertices.checked_add(merges)?.checked_mul(frames)?;
    Some((topology, spheres.checked_mul(12)?))
}

fn merge(bytes: &[u8; MERGE]) -> Merge {
    let word = |at: usize| [bytes[at], bytes[at + 1], bytes[at + 2], bytes[at + 3]];
    let mut total = [0; 8];
    total.copy_from_slice(&bytes[16..]);
    Merge {
        children: [0, 4].map(|at| u32::from_le_bytes(word(at))),
        radius: f32::from_le_bytes(word(8)),
        total: f64::from_le_bytes(total),
    }
}

/// What a checksum does not prove.
fn check(hierarchy: &Hierarchy) -> Parsed<()> {
    let vertices = hierarchy.vertices;
    if hierarchy.vertex.is_empty() || hierarchy.triangles.is_empty() {
        return refuse("topology", "it has no triangles");
    }
    let mut rows = hierarchy
        .vertex
        .iter()
        .chain(hierarchy.triangles.iter().flatten());
    if rows.any(|&row| row as usize >= vertices) {
        return refuse("topology", "it names a vertex that does not exist");
    }
    let mut used = vec![false; vertices + hierarchy.merges.len()];
    for (k, merge) in hierarchy.merges.iter().enumerate() {
        for child in merge.children.map(|c| c as usize) {
            if child >= vertices + k || std::mem::replace(&mut used[child], true) {
                return refuse(
                    "topology",
                    format!("collapse {k} has a part that it cannot have"),
                );
            }
        }
        if !((0.0..=GREATEST).contains(&merge.radius) && merge.total.is_finite()) {
            return refuse(
                "topology",
                format!("collapse {k} has numbers that are out of range"),
            );
        }
    }
    if !hierarchy.weight.is_finite() || hierarchy.weight < 0.0 {
        return refuse("head", "its numbers are out of range");
    }
    let (centres, size) = (&hierarchy.centres, hierarchy.diagonal);
    let far = |x: &f32| !(-GREATEST..=GREATEST).contains(x);
    if let Some(bad) = centres.iter().position(far) {
        let node = bad / (3 * hierarchy.frames);
        return refuse("spheres", format!("the centre of {node} is out of range"));
    }
    // All that is computed of these numbers stays within single precision.
    let far = centres.iter().fold(0.0f32, |far, x| far.max(x.abs()));
    let reach = hierarchy.origin.abs().max_element() + f64::from(far) * size;
    let near = hierarchy.origin.is_finite() && reach < 0.1 * f64::from(f32::MAX);
    if !(near && size > LEAST && size < 1.0 / LEAST) {
        return refuse("head", "its numbers are out of range");
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::sphere_mesh::tests::{bending, built};

    #[test]
    fn a_hierarchy_comes_back() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.dsm");
        let hierarchy = built(&bending(3));
        hierarchy.save(&path).unwrap();
        assert_eq!(Hierarchy::load(&path).unwrap(), hierarchy);
        let missing = Hierarchy::load(&dir.path().join("b.dsm")).unwrap_err();
        assert!(matches!(missing, Error::File { .. }));
    }

    #[test]
    fn every_damage_is_refused() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.dsm");
        built(&bending(1)).save(&path).unwrap();
        let good = fs::read(&path).unwrap();
        for at in (0..200).chain((200..good.len()).step_by(61)) {
            let mut bad = good.clone();
            bad[at] ^= 0x10;
            assert!(parse(&bad).is_err(), "byte {at}");
            assert!(parse(&good[..at]).is_err(), "length {at}");
        }
        let longer = [good.as_slice(), &[0]].concat();
        assert_eq!(parse(&longer).unwrap_err().0, "end");
        let mut newer = good;
        newer[7] = 9;
        assert!(parse(&newer).unwrap_err().1.contains("version 9"));
        fs::write(&path, "ply").unwrap();
        let error = Hierarchy::load(&path).unwrap_err().to_string();
        assert!(
            error.contains("a.dsm: head: it is no sphere-mesh"),
            "{error}"
        );
    }

    #[test]
    fn numbers_that_lie_under_a_right_checksum_are_refused() {
        let good = built(&bending(1));
        let changes: [fn(&mut Hierarchy); 17] = [
            |h| h.vertex[0] = u32::MAX,
            |h| h.triangles[3][1] = h.vertices as u32,
            |h| h.merges[5].children[0] = h.merges[5].children[1],
            |h| h.merges[0].children[0] = h.vertices as u32,
            |h| h.merges[2].radius = -1.0,
            |h| h.merges[2].total = f64::NAN,
            |h| h.centres[7] = f32::INFINITY,
            |h| h.diagonal = 0.0,
            |h| h.diagonal = 1e-300,
            |h| h.diagonal = 1e300,
            |h| h.origin.y = 1e300,
            |h| h.origin.y = f64::NAN,
            |h| h.weight = -1.0,
            |h| h.merges[2].radius = 3e38,
            |h| h.centres[7] = -3e38,
            |h| h.triangles.clear(),
            |h| h.vertex.clear(),
        ];
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.dsm");
        for (k, change) in changes.iter().enumerate() {
            let mut bad = good.clone();
            change(&mut bad);
            bad.save(&path).unwrap();
            let error = Hierarchy::load(&path).unwrap_err();
            assert!(matches!(error, Error::Asset { .. }), "{k}: {error}");
        }
    }
}
