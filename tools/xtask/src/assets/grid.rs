//! From a shape to quads: naive surface nets.

use std::collections::BTreeMap;

use glam::{DVec3, IVec3};

use super::shape::Shape;
use crate::Result;

/// Vertices and the quads between them, counter-clockwise seen from outside.
pub(crate) struct Quads {
    /// Positions, near the surface.
    pub(crate) positions: Vec<DVec3>,
    /// Rows of the four corners.
    pub(crate) faces: Vec<[u32; 4]>,
}

/// Distances at the nodes of a grid that is symmetric about the plane x = 0.
struct Samples {
    low: IVec3,
    size: IVec3,
    spacing: f64,
    values: Vec<f64>,
}

impl Samples {
    fn position(&self, node: IVec3) -> DVec3 {
        // Half a cell off, so that the plane of symmetry runs through the middle of cells.
        (node.as_dvec3() + DVec3::new(0.5, 0.25, 0.25)) * self.spacing
    }

    fn value(&self, node: IVec3) -> f64 {
        let at = node - self.low;
        self.values[((at.z * self.size.y + at.y) * self.size.x + at.x) as usize]
    }

    fn nodes(&self) -> impl Iterator<Item = IVec3> + use<> {
        let (low, size) = (self.low, self.size);
        (0..size.x * size.y * size.z)
            .map(move |i| low + IVec3::new(i % size.x, i / size.x % size.y, i / (size.x * size.y)))
    }
}

/// Polygonises the shape within a box: one vertex a cell that the surface crosses, one quad an edge that it crosses.
pub(crate) fn surface_nets(shape: &Shape, low: DVec3, high: DVec3, spacing: f64) -> Result<Quads> {
    let samples = sample(shape, low, high, spacing);
    let last = samples.low + samples.size - 1;
    let mut quads = Quads {
        positions: Vec::new(),
        faces: Vec::new(),
    };
    let mut vertex = BTreeMap::new();
    for cell in samples.nodes().filter(|c| c.cmplt(last).all()) {
        if let Some(position) = crossing(&samples, cell) {
            vertex.insert(cell.to_array(), quads.positions.len() as u32);
            quads.positions.push(position);
        }
    }
    let axes = [IVec3::X, IVec3::Y, IVec3::Z];
    for node in samples.nodes().filter(|c| c.cmplt(last).all()) {
        for (i, axis) in axes.into_iter().enumerate() {
            let (b, c) = (axes[(i + 1) % 3], axes[(i + 2) % 3]);
            let inside = [samples.value(node) < 0.0, samples.value(node + axis) < 0.0];
            if inside[0] == inside[1] {
                continue;
            }
            // The four cells around the edge, counter-clockwise about the axis.
            let cells = [node - b - c, node - c, node, node - b].map(|c| vertex.get(&c.to_array()));
            let [Some(p), Some(q), Some(r), Some(s)] = cells else {
                return Err("the shape leaves its box".into());
            };
            quads.faces.push(if inside[0] {
                [*p, *q, *r, *s]
            } else {
                [*s, *r, *q, *p]
            });
        }
    }
    Ok(quads)
}

fn sample(shape: &Shape, low: DVec3, high: DVec3, spacing: f64) -> Samples {
    let reach = high.max(-low);
    let low = DVec3::new(-reach.x, low.y, low.z) / spacing - 2.0;
    let high = DVec3::new(reach.x, high.y, high.z) / spacing + 2.0;
    // Nodes lie at (i + 1/2) spacing along x: from -n to n - 1.
    let half = high.x.ceil() as i32;
    let low = IVec3::new(-half, low.y.floor() as i32, low.z.floor() as i32);
    let size = IVec3::new(
        2 * half,
        high.y.ceil() as i32 - low.y,
        high.z.ceil() as i32 - low.z,
    );
    let mut samples = Samples {
        low,
        size,
        spacing,
        values: Vec::new(),
    };
    samples.values = samples
        .nodes()
        .map(|node| shape.distance(samples.position(node)))
        .collect();
    samples
}

/// Mean of the points where the surface crosses the twelve edges of a cell.
fn crossing(samples: &Samples, cell: IVec3) -> Option<DVec3> {
    let corner = |i: i32| cell + IVec3::new(i & 1, i >> 1 & 1, i >> 2);
    let (mut sum, mut count) = (DVec3::ZERO, 0);
    for i in 0..8 {
        for bit in [1, 2, 4] {
            if i & bit != 0 {
                continue;
            }
            let (from, to) = (corner(i), corner(i | bit));
            let (a, b) = (samples.value(from), samples.value(to));
            if (a < 0.0) != (b < 0.0) {
                sum += samples
                    .position(from)
                    .lerp(samples.position(to), a / (a - b));
                count += 1;
            }
        }
    }
    (count > 0).then(|| sum / f64::from(count))
}
