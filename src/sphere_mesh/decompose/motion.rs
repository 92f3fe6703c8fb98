//! Rigid motions of bones, four frames at once.

use glam::{DMat3, DVec3};
use nalgebra::Matrix3;

use crate::sphere_mesh::lanes::{S4, V4, X4};

/// A rotation, then a translation, in each of four frames.
#[derive(Clone, Copy, Debug)]
pub(super) struct Motion {
    /// Columns of the rotation.
    columns: [V4; 3],
    translation: V4,
}

impl Motion {
    pub(super) fn identity() -> Self {
        let mut motion = Self {
            columns: Default::default(),
            translation: V4::default(),
        };
        for k in 0..3 {
            motion.columns[k].0[k] = X4::splat(1.0);
        }
        motion
    }

    #[inline(always)]
    pub(super) fn apply(&self, p: DVec3) -> V4 {
        self.turn(p) + self.translation
    }

    /// The rotation alone.
    #[inline(always)]
    pub(super) fn turn(&self, p: DVec3) -> V4 {
        let [a, b, c] = self.columns;
        let [x, y, z] = [p.x, p.y, p.z].map(X4::splat);
        a.times(x) + b.times(y) + c.times(z)
    }

    pub(super) fn translation(&self) -> V4 {
        self.translation
    }

    pub(super) fn columns(&self) -> &[V4; 3] {
        &self.columns
    }

    /// What it moves points further than `other`, weights of points aside.
    #[inline(always)]
    pub(super) fn against(&self, other: &Self) -> Self {
        let (a, b) = (self.columns, other.columns);
        Self {
            columns: [a[0] - b[0], a[1] - b[1], a[2] - b[2]],
            translation: self.translation - other.translation,
        }
    }

    pub(super) fn lane(&self, lane: usize) -> (DMat3, DVec3) {
        let vector = |v: &V4| DVec3::from(v.0.map(|x| x.0[lane]));
        let [a, b, c] = self.columns.each_ref().map(vector);
        (DMat3::from_cols(a, b, c), vector(&self.translation))
    }

    pub(super) fn set(&mut self, lane: usize, rotation: DMat3, translation: DVec3) {
        for k in 0..3 {
            for axis in 0..3 {
                self.columns[k].0[axis].0[lane] = rotation.col(k)[axis];
            }
            self.translation.0[k].0[lane] = translation[k];
        }
    }
}

/// What a weighted rigid fit of sources to targets needs, in each of four frames.
#[derive(Clone, Copy, Default)]
pub(super) struct Fit {
    /// Sum of weights.
    mass: X4,
    source: V4,
    target: V4,
    /// Rows by the source's axis: sum of source times target.
    cross: [V4; 3],
    /// Sum of weight times the source's square, for the scale of the problem.
    square: X4,
}

impl Fit {
    /// Adds a source, its weight and its target times that weight.
    #[inline(always)]
    pub(super) fn add(&mut self, weight: X4, source: DVec3, weighted: V4) {
        let [x, y, z] = source.to_array().map(X4::splat);
        self.mass += weight;
        self.source = self.source + V4([x * weight, y * weight, z * weight]);
        self.target = self.target + weighted;
        for (row, axis) in self.cross.iter_mut().zip([x, y, z]) {
            *row = *row + weighted.times(axis);
        }
        self.square += weight * X4::splat(source.length_squared());
    }

    /// The rotation and translation that bring the sources nearest to the targets (Kabsch 1976); where they do not fix the
    /// rotation, that much of it is as in `before`. None without weight.
    pub(super) fn solve(&self, lane: usize, before: DMat3) -> Option<(DMat3, DVec3)> {
        let vector = |v: &V4| DVec3::from(v.0.map(|x| x.0[lane]));
        let mass = self.mass.0[lane];
        if mass.is_nan() || mass <= 1e-12 {
            return None;
        }
        let (source, target) = (vector(&self.source) / mass, vector(&self.target) / mass);
        // A trace of the rotation before: it decides only what the points leave open.
        let spread = self.square.0[lane] - mass * source.length_squared();
        let hold = 1e-6 * spread.max(1e-9 * mass);
        let mut m = Matrix3::zeros();
        for (row, cross) in self.cross.iter().enumerate() {
            let cross = vector(cross) - mass * source[row] * target;
            for column in 0..3 {
                // before maps source axis `row` to its column.
                m[(column, row)] = cross[column] + hold * before.col(row)[column];
            }
        }
        let rotation = nearest_rotation(m)?;
        Some((rotation, target - rotation * source))
    }
}

/// What the vertices of a bone say of its motion when the others' stay: the sums of μ w² p, of μ w² p pᵀ and of μ w times how
/// far a vertex is off, alone and times p, in each of four frames.
#[derive(Clone, Copy, Default)]
pub(super) struct Moments {
    mass: X4,
    source: V4,
    /// xx xy xz yy yz zz.
    second: S4,
    off: V4,
    cross: [V4; 3],
}

impl Moments {
    /// Adds a vertex: its area times its weight, its weight, its place at rest and how far it is off.
    #[inline(always)]
    pub(super) fn add(&mut self, area: X4, weight: f64, p: DVec3, off: V4) {
        let mass = area * X4::splat(weight);
        let [x, y, z] = [X4::splat(p.x), X4::splat(p.y), X4::splat(p.z)];
        let [mx, my, mz] = [mass * x, mass * y, mass * z];
        self.mass += mass;
        self.source = self.source + V4([mx, my, mz]);
        self.second = self.second + S4([mx * x, mx * y, mx * z, my * y, my * z, mz * z]);
        let off = off.times(area);
        self.off = self.off + off;
        for (row, x) in self.cross.iter_mut().zip([x, y, z]) {
            *row = *row + off.times(x);
        }
    }

    /// The fit of the bone to what the others leave: w (R p + T) − off for w times its own, which moved it as `before`.
    pub(super) fn wanted(&self, before: &Motion) -> Fit {
        let [a, b, c] = before.columns;
        let turn = |v: [X4; 3]| a.times(v[0]) + b.times(v[1]) + c.times(v[2]);
        let t = before.translation;
        let m = self.second.0;
        let rows = [[m[0], m[1], m[2]], [m[1], m[3], m[4]], [m[2], m[4], m[5]]];
        let mut cross = [V4::default(); 3];
        for k in 0..3 {
            cross[k] = turn(rows[k]) + t.times(self.source.0[k]) - self.cross[k];
        }
        Fit {
            mass: self.mass,
            source: self.source,
            target: turn(self.source.0) + t.times(self.mass) - self.off,
            cross,
            square: self.second.trace(),
        }
    }
}

/// The rotation R of the greatest trace of Rᵀ M, reflections mended.
pub(super) fn nearest_rotation(m: Matrix3<f64>) -> Option<DMat3> {
    let svd = m.try_svd(true, true, 1e-14, 100)?;
    let (mut u, v) = (svd.u?, svd.v_t?);
    if u.determinant() * v.determinant() < 0.0 {
        let least = svd.singular_values.imin();
        u.column_mut(least).neg_mut();
    }
    let r = u * v;
    let rotation = DMat3::from_cols_slice(r.as_slice());
    rotation.is_finite().then_some(rotation)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sphere_mesh::testing::Chance;

    #[test]
    #[allow(clippy::unwrap_used)]
    fn moments_want_what_the_vertices_want_one_by_one() {
        let mut chance = Chance(5);
        let mut vector = || chance.point(0.5);
        let spread = |v: DVec3| V4(v.to_array().map(|x| X4([x, 2.0 * x, -x, x + 0.1])));
        let mut before = Motion::identity();
        for lane in 0..4 {
            let rotation = DMat3::from_axis_angle(vector().normalize(), vector().x);
            before.set(lane, rotation, vector());
        }
        let (mut moments, mut direct) = (Moments::default(), Fit::default());
        for _ in 0..20 {
            let (p, off, weight) = (vector(), spread(vector()), vector().x + 0.6);
            let area = X4(vector().extend(0.4).to_array()) + X4::splat(0.6);
            moments.add(area * X4::splat(weight), weight, p, off);
            let mass = area * X4::splat(weight);
            let wanted = before.apply(p).times(X4::splat(weight)) - off;
            direct.add(mass * X4::splat(weight), p, wanted.times(mass));
        }
        let fit = moments.wanted(&before);
        for lane in 0..4 {
            let old = before.lane(lane).0;
            let (a, b) = (
                fit.solve(lane, old).unwrap(),
                direct.solve(lane, old).unwrap(),
            );
            assert!(a.0.abs_diff_eq(b.0, 1e-9) && a.1.abs_diff_eq(b.1, 1e-9));
            assert!(!a.0.abs_diff_eq(old, 1e-3), "nothing was wanted");
        }
    }
}
