//! One closed mesh of a shape: marching tetrahedra over the union of its solids, pockets filled.

use std::collections::HashMap;

use glam::{DVec3, IVec3};

use super::{
    shape::{Ball, Shape, Solid},
    tree::Bounds,
};
use crate::{Error, Result};

/// Greatest number of grid points.
const POINTS: usize = 1 << 27;
/// Half the thickness, in cells, that a sheet or wire is given at least: thinner ones fall between the points.
const THIN: f64 = 0.6;

/// Corners of the six tetrahedra of a cell, as bits x, y, z; all share the diagonal from 0 to 7, and neighbouring cells
/// cut their common face alike.
const TETRAHEDRA: [[usize; 4]; 6] = [
    [0, 1, 3, 7],
    [0, 3, 2, 7],
    [0, 2, 6, 7],
    [0, 6, 4, 7],
    [0, 4, 5, 7],
    [0, 5, 1, 7],
];

/// A closed mesh: positions and triangles, counter-clockwise seen from outside.
#[derive(Clone, Debug, Default)]
pub struct Skin {
    /// Positions, in the shape's units.
    pub positions: Vec<DVec3>,
    /// Triangles as rows of the positions.
    pub triangles: Vec<[u32; 3]>,
}

/// Signed distances on a regular grid.
struct Grid {
    low: DVec3,
    cell: f64,
    extent: IVec3,
    values: Vec<f32>,
}

/// Meshes the outer surface of a shape with `cells` cells along its longest side. Sheets and wires thinner than 1.2
/// cells are given that thickness; pockets that cannot be reached from outside are filled.
///
/// # Errors
/// [`Error::Argument`] for a number of cells that is out of range.
pub fn extract(shape: &Shape, cells: usize) -> Result<Skin> {
    if !(4..=1024).contains(&cells) {
        let reason = format!("{cells}, not 4 to 1024 along the longest side");
        return Err(Error::argument("cells", reason));
    }
    let mut grid = Grid::new(shape, cells)?;
    let thick = |ball: &Ball| Ball {
        radius: ball.radius.max(THIN * grid.cell),
        ..*ball
    };
    let thick = Shape {
        balls: shape.balls.iter().map(thick).collect(),
        ..shape.clone()
    };
    for solid in thick.solids() {
        grid.add(&solid);
    }
    grid.fill_pockets();
    Ok(grid.march())
}

impl Grid {
    fn new(shape: &Shape, cells: usize) -> Result<Self> {
        if shape.balls.is_empty() {
            return Err(Error::argument("shape", "it has no spheres"));
        }
        let ends = shape.balls.iter();
        let ends = ends.flat_map(|b| [b.centre - b.radius, b.centre + b.radius]);
        let bounds = Bounds::of(ends);
        let size = bounds.high - bounds.low;
        // A single point has no size; its cells are still larger than the rounding of its coordinates.
        let far = bounds.low.abs().max(bounds.high.abs()).max_element();
        let cell = (size.max_element() / cells as f64).max(1e-9 * far + 1e-30);
        let extent = (size / cell).ceil().as_ivec3() + 6;
        let [x, y, z] = extent.to_array().map(i64::from);
        let count = x.saturating_mul(y).saturating_mul(z);
        if !cell.is_finite() || count > POINTS as i64 {
            let reason = format!("a grid of {count} points, more than {POINTS}");
            return Err(Error::argument("cells", reason));
        }
        Ok(Self {
            low: bounds.low - 3.0 * cell,
            cell,
            extent,
            values: vec![f32::INFINITY; count as usize],
        })
    }

    fn row(&self, at: IVec3) -> usize {
        ((at.z * self.extent.y + at.y) * self.extent.x + at.x) as usize
    }

    fn point(&self, at: IVec3) -> DVec3 {
        self.low + at.as_dvec3() * self.cell
    }

    /// The union with a solid, exact within two cells around it.
    fn add(&mut self, solid: &Solid) {
        let bounds = solid.bounds();
        let to_cell = |p: DVec3| ((p - self.low) / self.cell).floor().as_ivec3();
        let from = (to_cell(bounds.low) - 2).max(IVec3::ZERO);
        let to = (to_cell(bounds.high) + 3).min(self.extent - 1);
        for z in from.z..=to.z {
            for y in from.y..=to.y {
                for x in from.x..=to.x {
                    let at = IVec3::new(x, y, z);
                    let distance = solid.distance(self.point(at)) as f32;
                    let row = self.row(at);
                    self.values[row] = self.values[row].min(distance);
                }
            }
        }
    }

    /// Points outside of every solid that no way along the grid joins to the border become inner ones.
    fn fill_pockets(&mut self) {
        let mut reached = vec![false; self.values.len()];
        reached[0] = true;
        let mut front = vec![IVec3::ZERO];
        while let Some(at) = front.pop() {
            for step in [IVec3::X, IVec3::Y, IVec3::Z] {
                for next in [at + step, at - step] {
                    if next.min_element() < 0 || (self.extent - 1 - next).min_element() < 0 {
                        continue;
                    }
                    let row = self.row(next);
                    if !reached[row] && self.values[row] > 0.0 {
                        reached[row] = true;
                        front.push(next);
                    }
                }
            }
        }
        for (value, reached) in self.values.iter_mut().zip(reached) {
            if *value > 0.0 && !reached {
                *value = -value.min(self.cell as f32);
            }
        }
    }

    fn march(&self) -> Skin {
        let mut skin = Skin::default();
        let mut known = HashMap::new();
        let last = self.extent - 1;
        for z in 0..last.z {
            for y in 0..last.y {
                for x in 0..last.x {
                    self.cell_of(IVec3::new(x, y, z), &mut known, &mut skin);
                }
            }
        }
        skin
    }

    fn cell_of(&self, at: IVec3, known: &mut HashMap<[usize; 2], u32>, skin: &mut Skin) {
        let corner = |bits: usize| {
            let step = IVec3::from([0, 1, 2].map(|k| (bits >> k & 1) as i32));
            self.row(at + step)
        };
        let rows: [usize; 8] = std::array::from_fn(corner);
        let inner = |row: usize| self.values[row] <= 0.0;
        let count = rows.iter().filter(|&&row| inner(row)).count();
        if count == 0 || count == 8 {
            return;
        }
        for tetrahedron in TETRAHEDRA {
            let rows = tetrahedron.map(|bits| rows[bits]);
            let (a, b): (Vec<usize>, Vec<usize>) = rows.iter().partition(|&&row| inner(row));
            let mut cut = |p: usize, q: usize| self.cut(p, q, known, skin);
            let polygon = match (a.as_slice(), b.as_slice()) {
                (&[p], &[q, r, s]) | (&[q, r, s], &[p]) => vec![cut(p, q), cut(p, r), cut(p, s)],
                (&[p, q], &[r, s]) => vec![cut(p, r), cut(p, s), cut(q, s), cut(q, r)],
                _ => continue,
            };
            let side = self.outwards(&polygon, a[0], skin);
            for k in 1..polygon.len() - 1 {
                let (p, q, r) = (polygon[0], polygon[k], polygon[k + 1]);
                skin.triangles
                    .push(if side { [p, q, r] } else { [p, r, q] });
            }
        }
    }

    /// Whether the polygon turns its front away from an inner point.
    fn outwards(&self, polygon: &[u32], inner: usize, skin: &Skin) -> bool {
        let [a, b, c] = [0, 1, 2].map(|k| skin.positions[polygon[k] as usize]);
        (b - a).cross(c - a).dot(a - self.place(inner)) > 0.0
    }

    fn place(&self, row: usize) -> DVec3 {
        let (x, y) = (self.extent.x as usize, self.extent.y as usize);
        let at = [row % x, row / x % y, row / x / y].map(|k| k as i32);
        self.point(IVec3::from(at))
    }

    /// Vertex on the edge between an inner and an outer point; never quite at an end, so that no triangle vanishes.
    fn cut(
        &self,
        p: usize,
        q: usize,
        known: &mut HashMap<[usize; 2], u32>,
        skin: &mut Skin,
    ) -> u32 {
        let key = [p.min(q), p.max(q)];
        *known.entry(key).or_insert_with(|| {
            let [a, b] = key.map(|row| f64::from(self.values[row]));
            let t = if b.is_finite() && a.is_finite() {
                a / (a - b)
            } else {
                0.5
            };
            let (from, to) = (self.place(key[0]), self.place(key[1]));
            skin.positions
                .push(from + (to - from) * t.clamp(0.01, 0.99));
            skin.positions.len() as u32 - 1
        })
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn ball(x: f64, y: f64, radius: f64) -> Ball {
        Ball {
            centre: DVec3::new(x, y, 0.0),
            radius,
        }
    }

    fn volume(skin: &Skin) -> f64 {
        let corner = |v: u32| skin.positions[v as usize];
        let six = |t: &[u32; 3]| {
            let [a, b, c] = t.map(corner);
            a.dot(b.cross(c))
        };
        skin.triangles.iter().map(six).sum::<f64>() / 6.0
    }

    fn closed(skin: &Skin) {
        let mut sides = std::collections::HashMap::<[u32; 2], i32>::new();
        for t in &skin.triangles {
            for k in 0..3 {
                let (a, b) = (t[k], t[(k + 1) % 3]);
                *sides.entry([a.min(b), a.max(b)]).or_default() += if a < b { 1 } else { -1 };
                let length = skin.positions[a as usize].distance(skin.positions[b as usize]);
                assert!(length > 0.0);
            }
        }
        assert!(
            sides.values().all(|&n| n == 0),
            "a side without its opposite"
        );
    }

    #[test]
    fn a_cone_and_a_ball_have_their_volumes() {
        let shape = Shape {
            balls: vec![
                ball(0.0, 0.0, 0.5),
                ball(2.0, 0.0, 0.5),
                ball(0.0, 4.0, 1.0),
            ],
            edges: vec![[0, 1]],
            triangles: Vec::new(),
        };
        let skin = extract(&shape, 100).unwrap();
        closed(&skin);
        let pi = std::f64::consts::PI;
        let exact = pi * 0.25 * 2.0 + 4.0 / 3.0 * pi * (0.125 + 1.0);
        assert!(
            (volume(&skin) - exact).abs() < 0.01 * exact,
            "{}",
            volume(&skin)
        );
    }

    #[test]
    fn sheets_without_thickness_stay_and_pockets_are_filled() {
        let corners = [(0.0, 0.0), (2.0, 0.0), (0.0, 2.0)].map(|(x, y)| ball(x, y, 0.0));
        let sheet = Shape {
            balls: corners.to_vec(),
            edges: Vec::new(),
            triangles: vec![[0, 1, 2]],
        };
        let skin = extract(&sheet, 40).unwrap();
        closed(&skin);
        let thick = volume(&skin) / 2.0;
        assert!((0.04..0.1).contains(&thick), "{thick}");
        let z = |z: f64| {
            move |b: &Ball| Ball {
                centre: b.centre + DVec3::Z * z,
                ..*b
            }
        };
        let mut tetrahedron = sheet.clone();
        tetrahedron.balls.push(z(2.0)(&corners[0]));
        tetrahedron.triangles = vec![[0, 1, 2], [0, 1, 3], [0, 2, 3], [1, 2, 3]];
        let skin = extract(&tetrahedron, 40).unwrap();
        closed(&skin);
        assert!(volume(&skin) > 8.0 / 6.0, "{}", volume(&skin));
    }

    #[test]
    fn one_point_or_too_many_cells_are_no_panic() {
        let point = Shape {
            balls: vec![ball(1.0, 2.0, 0.0)],
            ..Shape::default()
        };
        closed(&extract(&point, 10).unwrap());
        assert!(extract(&point, 0).is_err());
        assert!(extract(&Shape::default(), 10).is_err());
    }
}
