//! Rigid motions of bones, four frames at once.

use glam::{DMat3, DVec3};
use nalgebra::Matrix3;

use crate::sphere_mesh::lanes::{V4, X4};

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
