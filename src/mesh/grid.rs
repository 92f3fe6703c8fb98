//! Rays against triangles, sped up by a uniform grid (Amanatides & Woo 1987; Möller & Trumbore 1997).

use glam::{DVec3, IVec3};

use super::{Csr, Mesh};

/// Most cells along an axis.
const CELLS: f64 = 96.0;
/// Most entries a triangle, on average; long triangles must not fill the whole grid.
const ENTRIES: usize = 64;

/// Triangles of a mesh by the grid cells that their bounding boxes meet.
#[derive(Debug)]
pub struct TriangleGrid<'a> {
    mesh: &'a Mesh,
    origin: DVec3,
    cell: f64,
    extent: IVec3,
    cells: Csr,
}

impl<'a> TriangleGrid<'a> {
    /// Sorts the triangles into cells about as many as there are triangles.
    pub fn new(mesh: &'a Mesh) -> Self {
        let points = || mesh.positions.iter().map(|p| p.as_dvec3());
        let low = points().reduce(DVec3::min).unwrap_or_default();
        let high = points().reduce(DVec3::max).unwrap_or_default();
        let size = high - low;
        let longest = size.max_element().max(f64::MIN_POSITIVE);
        let padded = size.max(DVec3::splat(longest * 1e-3));
        let wanted = (mesh.triangles.len() as f64).max(1.0);
        let cell = (padded.element_product() / wanted)
            .cbrt()
            .max(longest / CELLS);
        let mut grid = Self {
            mesh,
            origin: low,
            cell,
            extent: IVec3::ONE,
            cells: Csr::default(),
        };
        loop {
            grid.extent = (padded / grid.cell).floor().as_ivec3() + 1;
            let boxes = mesh.triangles.iter().map(|t| grid.cells_of(*t));
            let entries = boxes.map(|(from, to)| (to - from + 1).element_product() as usize);
            if entries.sum::<usize>() <= ENTRIES * mesh.triangles.len() || grid.extent == IVec3::ONE
            {
                break;
            }
            grid.cell *= 2.0;
        }
        grid.fill();
        grid
    }

    /// Cells that a triangle's bounding box meets, both ends included.
    fn cells_of(&self, triangle: [u32; 3]) -> (IVec3, IVec3) {
        let [a, b, c] = triangle.map(|v| self.mesh.positions[v as usize].as_dvec3());
        (self.locate(a.min(b).min(c)), self.locate(a.max(b).max(c)))
    }

    fn fill(&mut self) {
        let mut rows = vec![Vec::new(); self.extent.element_product() as usize];
        for (row, t) in self.mesh.triangles.iter().enumerate() {
            let (from, to) = self.cells_of(*t);
            for z in from.z..=to.z {
                for y in from.y..=to.y {
                    for x in from.x..=to.x {
                        rows[self.index(IVec3::new(x, y, z))].push(row as u32);
                    }
                }
            }
        }
        self.cells = Csr::from_rows(&rows);
    }

    /// Nearest hit of `origin + t direction` with t in (0, `limit`], among the triangles that `accept` takes.
    ///
    /// Answers t and the triangle. `accept` may see a triangle more than once.
    pub fn first_hit(
        &self,
        origin: DVec3,
        direction: DVec3,
        limit: f64,
        accept: impl Fn(usize) -> bool,
    ) -> Option<(f64, usize)> {
        let (begin, end) = self.clip(origin, direction, limit)?;
        let mut at = self.locate(origin + direction * begin);
        let mut best: Option<(f64, usize)> = None;
        loop {
            for &row in self.cells.row(self.index(at)) {
                let row = row as usize;
                if !accept(row) {
                    continue;
                }
                if let Some(hit) = self.intersect(row, origin, direction)
                    && hit <= limit
                    && best.is_none_or(|b| (hit, row) < b)
                {
                    best = Some((hit, row));
                }
            }
            let (axis, exit) = self.exit(at, origin, direction);
            // A hit before the cell's exit cannot be beaten by a later cell.
            if best.is_some_and(|b| b.0 <= exit) || exit >= end {
                return best;
            }
            at[axis] += if direction[axis] > 0.0 { 1 } else { -1 };
            if at[axis] < 0 || at[axis] >= self.extent[axis] {
                return best;
            }
        }
    }

    fn locate(&self, p: DVec3) -> IVec3 {
        ((p - self.origin) / self.cell)
            .floor()
            .as_ivec3()
            .clamp(IVec3::ZERO, self.extent - 1)
    }

    fn index(&self, at: IVec3) -> usize {
        ((at.z * self.extent.y + at.y) * self.extent.x + at.x) as usize
    }

    /// Part of the ray within the grid's box.
    fn clip(&self, origin: DVec3, direction: DVec3, limit: f64) -> Option<(f64, f64)> {
        let far = self.origin + self.extent.as_dvec3() * self.cell;
        let (mut begin, mut end) = (0.0f64, limit);
        for k in 0..3 {
            if direction[k] == 0.0 {
                if origin[k] < self.origin[k] || origin[k] > far[k] {
                    return None;
                }
                continue;
            }
            let a = (self.origin[k] - origin[k]) / direction[k];
            let b = (far[k] - origin[k]) / direction[k];
            begin = begin.max(a.min(b));
            end = end.min(a.max(b));
        }
        (begin <= end).then_some((begin, end))
    }

    /// Axis and parameter at which the ray leaves a cell.
    fn exit(&self, at: IVec3, origin: DVec3, direction: DVec3) -> (usize, f64) {
        let mut first = (0, f64::INFINITY);
        for k in 0..3 {
            if direction[k] != 0.0 {
                let side = at[k] + i32::from(direction[k] > 0.0);
                let face = self.origin[k] + f64::from(side) * self.cell;
                let t = (face - origin[k]) / direction[k];
                if t < first.1 {
                    first = (k, t);
                }
            }
        }
        first
    }

    fn intersect(&self, row: usize, origin: DVec3, direction: DVec3) -> Option<f64> {
        let [a, b, c] =
            self.mesh.triangles[row].map(|v| self.mesh.positions[v as usize].as_dvec3());
        let (u, v) = (b - a, c - a);
        let p = direction.cross(v);
        let determinant = u.dot(p);
        if determinant == 0.0 {
            return None;
        }
        let s = origin - a;
        let x = s.dot(p) / determinant;
        let q = s.cross(u);
        let y = direction.dot(q) / determinant;
        let t = v.dot(q) / determinant;
        (x >= 0.0 && y >= 0.0 && x + y <= 1.0 && t > 0.0).then_some(t)
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use glam::Vec3;

    /// A bumpy closed surface of revolution.
    fn blob() -> Mesh {
        let (n, m) = (24u32, 16u32);
        let mut p = Vec::new();
        for j in 0..=m {
            for i in 0..n {
                let (a, b) = (
                    i as f32 / n as f32 * std::f32::consts::TAU,
                    j as f32 / m as f32 * std::f32::consts::PI,
                );
                let r = 1.0 + 0.3 * (3.0 * a).sin() * b.sin();
                p.push(r * Vec3::new(b.sin() * a.cos(), b.sin() * a.sin(), 2.0 * b.cos()));
            }
        }
        let mut t = Vec::new();
        for j in 0..m {
            for i in 0..n {
                let (a, b) = (j * n + i, j * n + (i + 1) % n);
                t.push([a, a + n, b]);
                t.push([b, a + n, b + n]);
            }
        }
        crate::mesh::weld(&p, &t).mesh
    }

    #[test]
    fn agrees_with_trying_every_triangle() {
        let mesh = blob();
        let grid = TriangleGrid::new(&mesh);
        let mut hits = 0;
        for i in 0..400u32 {
            let x = f64::from(i);
            let origin = DVec3::new((x * 0.7).sin(), (x * 1.3).cos(), (x * 0.37).sin()) * 2.5;
            let jitter = DVec3::new((x * 2.1).cos(), (x * 0.9).sin(), (x * 1.7).cos());
            let direction = jitter * 1.5 - origin;
            let all = (0..mesh.triangles.len())
                .filter_map(|t| grid.intersect(t, origin, direction).map(|h| (h, t)))
                .filter(|h| h.0 <= 3.0)
                .min_by(|a, b| a.partial_cmp(b).unwrap());
            hits += usize::from(all.is_some());
            assert_eq!(grid.first_hit(origin, direction, 3.0, |_| true), all);
        }
        assert!(hits > 50, "{hits}");
    }

    #[test]
    fn hits_lie_between_origin_and_limit_and_obey_the_filter() {
        let mesh = blob();
        let grid = TriangleGrid::new(&mesh);
        let up = DVec3::new(0.01, 0.02, 1.0);
        let (t, row) = grid.first_hit(DVec3::ZERO, up, 9.0, |_| true).unwrap();
        assert!((t - 2.0).abs() < 0.1);
        assert!(
            grid.first_hit(DVec3::ZERO, up, t * 0.99, |_| true)
                .is_none()
        );
        assert!(grid.first_hit(DVec3::ZERO, up, 9.0, |r| r != row).is_none());
        assert!(grid.first_hit(DVec3::Z * 5.0, up, 9.0, |_| true).is_none());
    }

    #[test]
    fn long_triangles_do_not_fill_the_grid() {
        let n = 3000u32;
        let p = (0..3 * n).map(|k| {
            let x = f64::from(k) * 0.7;
            DVec3::new(x.sin(), (1.3 * x).cos(), (1.7 * x).sin()).as_vec3()
        });
        let mesh = Mesh::new(
            p.collect(),
            (0..n).map(|k| [3 * k, 3 * k + 1, 3 * k + 2]).collect(),
        );
        let grid = TriangleGrid::new(&mesh);
        assert!(grid.cells.items.len() <= ENTRIES * n as usize);
        assert!(
            grid.first_hit(DVec3::splat(-2.0), DVec3::ONE, 9.0, |_| true)
                .is_some()
        );
    }
}
