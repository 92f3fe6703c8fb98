//! A sequence made ready: welded, scaled, a vertex's frames side by side.

use glam::{DVec3, Vec3};
use rayon::prelude::*;

use super::lanes::{LANES, Points};
use crate::{
    Error, Result,
    asset::Sequence,
    mesh::{Mesh, weld},
};

/// Rows of one place in all frames are one vertex, up to this share of the bounding box's diagonal.
const QUANTUM: f32 = 1e-6;

/// Diagonals from the first frame: beyond, single precision holds next to nothing of the shape.
const FARTHEST: f64 = 1e6;

/// The welded vertices of a sequence in all frames, in units of [`Input::diagonal`] about [`Input::origin`].
#[derive(Clone, Debug)]
pub(super) struct Input {
    /// Topology, with the positions of the first frame in the sequence's own units.
    pub(super) mesh: Mesh,
    /// Welded vertex of each row of the sequence.
    pub(super) vertex: Vec<u32>,
    pub(super) frames: usize,
    /// Groups of four frames; the last frame is repeated where it does not fill its group.
    pub(super) groups: usize,
    /// `[vertex][group]`.
    pub(super) positions: Vec<Points>,
    pub(super) origin: DVec3,
    /// Mean over the frames of the bounding box's diagonal.
    pub(super) diagonal: f64,
}

impl Input {
    /// Welds and scales a sequence.
    pub(super) fn new(sequence: &Sequence) -> Result<Self> {
        let refuse = |reason: &str| Err(Error::asset(&sequence.path, "sequence", reason));
        let Some(first) = sequence.frames.first() else {
            return refuse("it has no frames");
        };
        if let Some(frame) = sequence.frames.iter().position(|f| f.len() != first.len()) {
            let reason = format!(
                "{} vertices, not {}",
                sequence.frames[frame].len(),
                first.len()
            );
            return Err(Error::asset(
                &sequence.path,
                format!("frame {frame}"),
                reason,
            ));
        }
        for (frame, rows) in sequence.frames.iter().enumerate() {
            if let Some(bad) = rows.iter().position(|p| !p.is_finite()) {
                let element = format!("frame {frame}, vertex {bad}");
                return Err(Error::asset(&sequence.path, element, "not finite"));
            }
        }
        let outside = |t: &[u32; 3]| t.iter().any(|&v| v as usize >= first.len());
        if let Some(bad) = sequence.triangles.iter().position(outside) {
            let element = format!("triangle {bad}");
            return Err(Error::asset(
                &sequence.path,
                element,
                "a corner out of range",
            ));
        }
        let boxes: Vec<(Vec3, Vec3)> = sequence.frames.iter().map(|f| bounds(f)).collect();
        let diagonals = boxes
            .iter()
            .map(|(l, h)| (h.as_dvec3() - l.as_dvec3()).length());
        let diagonal = diagonals.sum::<f64>() / boxes.len() as f64;
        if !(diagonal > 1e-30 && diagonal < 1e30) {
            return refuse("all its vertices are at one place, or too far from each other");
        }
        let (vertex, rows) = weld_rows(&sequence.frames, diagonal as f32 * QUANTUM);
        let mesh = topology(sequence, &vertex, &rows);
        if mesh.triangles.is_empty() {
            return refuse("no triangle has three distinct corners");
        }
        let origin = (boxes[0].0.as_dvec3() + boxes[0].1.as_dvec3()) * 0.5;
        let far = |p: Vec3| (p.as_dvec3() - origin).abs().max_element() > FARTHEST * diagonal;
        if let Some(frame) = boxes.iter().position(|&(l, h)| far(l) || far(h)) {
            let reason = format!("it is more than {FARTHEST:e} diagonals from the first");
            let element = format!("frame {frame}");
            return Err(Error::asset(&sequence.path, element, reason));
        }
        let frames = sequence.frames.len();
        let groups = frames.div_ceil(LANES);
        let mut positions = vec![[[0.0; LANES]; 3]; mesh.positions.len() * groups];
        let places = positions.par_chunks_exact_mut(groups).zip(&rows);
        places.for_each(|(place, &row)| {
            for f in 0..groups * LANES {
                let p = sequence.frames[f.min(frames - 1)][row as usize].as_dvec3();
                let p = (p - origin) / diagonal;
                for k in 0..3 {
                    place[f / LANES][k][f % LANES] = p[k] as f32;
                }
            }
        });
        Ok(Self {
            mesh,
            vertex,
            frames,
            groups,
            positions,
            origin,
            diagonal,
        })
    }

    /// Positions of a vertex, a group after the other.
    pub(super) fn position(&self, vertex: usize) -> &[Points] {
        &self.positions[vertex * self.groups..][..self.groups]
    }
}

fn bounds(points: &[Vec3]) -> (Vec3, Vec3) {
    let ends = (Vec3::INFINITY, Vec3::NEG_INFINITY);
    points.iter().fold(ends, |(l, h), &p| (l.min(p), h.max(p)))
}

/// Vertex of each row and the first row of each vertex: rows that coincide in the first frame and in all others.
fn weld_rows(frames: &[Vec<Vec3>], quantum: f32) -> (Vec<u32>, Vec<u32>) {
    let place = weld(&frames[0], &[]).vertex;
    let mut at: Vec<Vec<u32>> = vec![Vec::new(); place.iter().max().map_or(0, |&p| p as usize + 1)];
    let mut rows = Vec::new();
    let near = |a: usize, b: usize| {
        let mut pairs = frames.iter().map(|f| f[a].distance(f[b]));
        pairs.all(|d| d <= quantum)
    };
    let vertex = place.iter().enumerate().map(|(row, &place)| {
        let here = &mut at[place as usize];
        let known = here.iter().find(|&&v| near(rows[v as usize] as usize, row));
        known.copied().unwrap_or_else(|| {
            here.push(rows.len() as u32);
            rows.push(row as u32);
            rows.len() as u32 - 1
        })
    });
    (vertex.collect(), rows)
}

fn topology(sequence: &Sequence, vertex: &[u32], rows: &[u32]) -> Mesh {
    let first = &sequence.frames[0];
    let positions = rows.iter().map(|&row| first[row as usize]).collect();
    let triangles = sequence.triangles.iter();
    let triangles = triangles.map(|t| t.map(|row| vertex[row as usize]));
    let proper = triangles.filter(|[a, b, c]| a != b && b != c && c != a);
    Mesh::new(positions, proper.collect())
}
