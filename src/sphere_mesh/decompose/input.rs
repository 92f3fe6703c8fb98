//! The clips made ready: welded as the sphere-mesh is, scaled by its diagonal, four frames side by side.

use glam::{DVec3, Vec3};
use rayon::prelude::*;

use crate::{
    Error, Result,
    asset::Sequence,
    sphere_mesh::{
        hierarchy::Hierarchy,
        lanes::{LANES, Points, V4, X4},
    },
};

/// Rows of one vertex are at one place up to this share of the diagonal.
const QUANTUM: f64 = 1e-5;
/// Least area of a vertex in a frame, as a share of the mean: without area it would not count.
const LEAST_AREA: f64 = 1e-6;

/// Up to four frames of one clip.
pub(super) struct Chunk {
    /// Frames; what fills the group repeats the last and has no area.
    pub(super) frames: usize,
    /// Of each vertex, in units of the diagonal about the origin.
    positions: Vec<Points>,
    /// Area of each vertex's barycentric cell, as a share of the mean.
    areas: Vec<[f32; LANES]>,
}

impl Chunk {
    #[inline(always)]
    pub(super) fn position(&self, vertex: usize) -> V4 {
        V4::widen(&self.positions[vertex])
    }

    #[inline(always)]
    pub(super) fn area(&self, vertex: usize) -> X4 {
        X4::widen(self.areas[vertex])
    }
}

/// All clips, one after the other.
pub(super) struct Frames {
    pub(super) vertices: usize,
    pub(super) chunks: Vec<Chunk>,
    /// Frames of each clip.
    pub(super) clips: Vec<usize>,
    /// Sum of each vertex's areas over the frames.
    pub(super) weight: Vec<f64>,
    /// Mean of the bounding boxes' diagonals, in units of the sphere-mesh's; its, where all frames are points.
    pub(super) diagonal: f64,
}

impl Frames {
    pub(super) fn new(hierarchy: &Hierarchy, clips: &[Sequence]) -> Result<Self> {
        if clips.is_empty() {
            return Err(Error::argument("clips", "none is given"));
        }
        let first = first_rows(hierarchy);
        clips
            .iter()
            .try_for_each(|clip| check(hierarchy, &first, clip))?;
        let all = clips.iter().flat_map(|clip| clip.frames.chunks(LANES));
        let all: Vec<&[Vec<Vec3>]> = all.collect();
        let mut chunks: Vec<Chunk> = all
            .par_iter()
            .map(|frames| chunk(hierarchy, &first, frames))
            .collect();
        normalise(&mut chunks, hierarchy.vertices);
        let weight = |v| chunks.iter().map(|c| c.area(v).sum()).sum();
        let frames: Vec<&Vec<Vec3>> = clips.iter().flat_map(|clip| &clip.frames).collect();
        let diagonals: f64 = frames.iter().map(|f| diagonal(f)).sum();
        Ok(Self {
            vertices: hierarchy.vertices,
            clips: clips.iter().map(|clip| clip.frames.len()).collect(),
            weight: (0..hierarchy.vertices)
                .into_par_iter()
                .map(weight)
                .collect(),
            diagonal: if diagonals > 0.0 {
                diagonals / frames.len() as f64 / hierarchy.diagonal
            } else {
                1.0
            },
            chunks,
        })
    }

    /// A vertex in the first frame.
    pub(super) fn first(&self, vertex: usize) -> DVec3 {
        let p = self.chunks[0].position(vertex);
        DVec3::from(p.0.map(|x| x.0[0]))
    }

    pub(super) fn frames(&self) -> usize {
        self.clips.iter().sum()
    }
}

fn first_rows(hierarchy: &Hierarchy) -> Vec<usize> {
    let mut first = vec![0; hierarchy.vertices];
    for (row, &vertex) in hierarchy.vertex.iter().enumerate().rev() {
        first[vertex as usize] = row;
    }
    first
}

/// A clip must be of the mesh that the sphere-mesh was built from.
fn check(hierarchy: &Hierarchy, first: &[usize], clip: &Sequence) -> Result<()> {
    let refuse = |element: String, reason: String| Err(Error::asset(&clip.path, element, reason));
    if clip.frames.is_empty() {
        return refuse("sequence".into(), "it has no frames".into());
    }
    let rows = hierarchy.vertex.len();
    for (f, frame) in clip.frames.iter().enumerate() {
        if frame.len() != rows {
            let reason = format!("{} vertices, but the sphere-mesh has {rows}", frame.len());
            return refuse(format!("frame {f}"), reason);
        }
        if let Some(bad) = frame.iter().position(|p| !p.is_finite()) {
            return refuse(format!("frame {f}, vertex {bad}"), "not finite".into());
        }
        let near = (hierarchy.diagonal * QUANTUM) as f32;
        let apart = |(row, &vertex): (usize, &u32)| {
            frame[row].distance(frame[first[vertex as usize]]) > near
        };
        if let Some(row) = hierarchy.vertex.iter().enumerate().position(apart) {
            let other = first[hierarchy.vertex[row] as usize];
            let reason =
                format!("apart from vertex {other}, with which the sphere-mesh has it as one");
            return refuse(format!("frame {f}, vertex {row}"), reason);
        }
    }
    let mut welded = Vec::with_capacity(hierarchy.triangles.len());
    for (row, corners) in clip.triangles.iter().enumerate() {
        let vertex = corners.map(|c| hierarchy.vertex.get(c as usize).copied());
        let [Some(a), Some(b), Some(c)] = vertex else {
            return refuse(format!("triangle {row}"), "a corner out of range".into());
        };
        if a != b && b != c && c != a {
            let wanted = hierarchy.triangles.get(welded.len());
            if wanted != Some(&[a, b, c]) {
                return refuse(
                    format!("triangle {row}"),
                    "not a face of the sphere-mesh's mesh".into(),
                );
            }
            welded.push(row);
        }
    }
    if welded.len() != hierarchy.triangles.len() {
        let (here, there) = (welded.len(), hierarchy.triangles.len());
        let reason =
            format!("{here} triangles with three corners, but the sphere-mesh has {there}");
        return refuse("triangles".into(), reason);
    }
    Ok(())
}

fn chunk(hierarchy: &Hierarchy, first: &[usize], frames: &[Vec<Vec3>]) -> Chunk {
    let mut positions = vec![[[0.0; LANES]; 3]; hierarchy.vertices];
    for (place, &row) in positions.iter_mut().zip(first) {
        for lane in 0..LANES {
            let p = frames[lane.min(frames.len() - 1)][row].as_dvec3();
            let p = (p - hierarchy.origin) / hierarchy.diagonal;
            for k in 0..3 {
                place[k][lane] = p[k] as f32;
            }
        }
    }
    let mut chunk = Chunk {
        frames: frames.len(),
        areas: vec![[0.0; LANES]; hierarchy.vertices],
        positions,
    };
    for t in &hierarchy.triangles {
        let [a, b, c] = t.map(|v| chunk.position(v as usize));
        let n = (b - a).cross(c - a);
        let third = n.dot(n).map(|square| square.sqrt() / 6.0);
        for v in t {
            for lane in 0..frames.len() {
                chunk.areas[*v as usize][lane] += third.0[lane] as f32;
            }
        }
    }
    chunk
}

/// Areas as shares of their mean, none too small.
fn normalise(chunks: &mut [Chunk], vertices: usize) {
    let count: usize = chunks.iter().map(|c| c.frames * vertices).sum();
    let sum: f64 = chunks
        .iter()
        .flat_map(|c| c.areas.as_flattened())
        .map(|a| f64::from(*a))
        .sum();
    let mean = (sum / count as f64).max(f64::MIN_POSITIVE);
    for chunk in chunks {
        for areas in &mut chunk.areas {
            for area in &mut areas[..chunk.frames] {
                *area = (f64::from(*area) / mean).max(LEAST_AREA) as f32;
            }
        }
    }
}

fn diagonal(points: &[Vec3]) -> f64 {
    let ends = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    let (low, high) = points.iter().fold(ends, |(l, h), p| {
        let p = p.as_dvec3();
        (l.min(p), h.max(p))
    });
    (high - low).length()
}
