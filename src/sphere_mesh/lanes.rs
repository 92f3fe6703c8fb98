//! Four frames at once: plain arrays that the compiler turns into vector instructions.

use std::ops::{Add, AddAssign, Mul, Sub};

/// Frames of a group.
pub(super) const LANES: usize = 4;

/// One number in each of four frames.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct X4(pub(super) [f64; LANES]);

impl X4 {
    pub(super) fn splat(x: f64) -> Self {
        Self([x; LANES])
    }

    /// The group at `at` of a slice.
    #[inline(always)]
    pub(super) fn load(from: &[f64], at: usize) -> Self {
        let mut x = [0.0; LANES];
        x.copy_from_slice(&from[at..at + LANES]);
        Self(x)
    }

    /// The group at `at` of a slice of single precision.
    #[inline(always)]
    pub(super) fn widen(from: &[f32], at: usize) -> Self {
        let from = &from[at..at + LANES];
        let [a, b, c, d] = [from[0], from[1], from[2], from[3]];
        Self([f64::from(a), f64::from(b), f64::from(c), f64::from(d)])
    }

    #[inline(always)]
    pub(super) fn map(self, f: impl Fn(f64) -> f64) -> Self {
        // Not `array::map`, which is not always inlined.
        let [a, b, c, d] = self.0;
        Self([f(a), f(b), f(c), f(d)])
    }

    #[inline(always)]
    pub(super) fn zip(self, other: Self, f: impl Fn(f64, f64) -> f64) -> Self {
        let (a, b) = (self.0, other.0);
        Self([f(a[0], b[0]), f(a[1], b[1]), f(a[2], b[2]), f(a[3], b[3])])
    }

    #[inline(always)]
    pub(super) fn sum(self) -> f64 {
        (self.0[0] + self.0[1]) + (self.0[2] + self.0[3])
    }
}

impl Add for X4 {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        self.zip(other, |a, b| a + b)
    }
}

impl AddAssign for X4 {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl Sub for X4 {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        self.zip(other, |a, b| a - b)
    }
}

impl Mul for X4 {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        self.zip(other, |a, b| a * b)
    }
}

/// A vector in each of four frames.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct V4(pub(super) [X4; 3]);

impl V4 {
    /// The group at `at` of three rows of `stride` numbers.
    #[inline(always)]
    pub(super) fn load(from: &[f64], stride: usize, at: usize) -> Self {
        Self([
            X4::load(from, at),
            X4::load(from, stride + at),
            X4::load(from, 2 * stride + at),
        ])
    }

    /// As [`V4::load`], of single precision.
    #[inline(always)]
    pub(super) fn widen(from: &[f32], stride: usize, at: usize) -> Self {
        Self([
            X4::widen(from, at),
            X4::widen(from, stride + at),
            X4::widen(from, 2 * stride + at),
        ])
    }

    #[inline(always)]
    pub(super) fn dot(self, other: Self) -> X4 {
        let (a, b) = (self.0, other.0);
        a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
    }

    #[inline(always)]
    pub(super) fn cross(self, other: Self) -> Self {
        let (a, b) = (self.0, other.0);
        Self([
            a[1] * b[2] - a[2] * b[1],
            a[2] * b[0] - a[0] * b[2],
            a[0] * b[1] - a[1] * b[0],
        ])
    }

    #[inline(always)]
    pub(super) fn times(self, factor: X4) -> Self {
        let [x, y, z] = self.0;
        Self([x * factor, y * factor, z * factor])
    }
}

impl Add for V4 {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        let (a, b) = (self.0, other.0);
        Self([a[0] + b[0], a[1] + b[1], a[2] + b[2]])
    }
}

impl Sub for V4 {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        let (a, b) = (self.0, other.0);
        Self([a[0] - b[0], a[1] - b[1], a[2] - b[2]])
    }
}

/// A symmetric matrix in each of four frames: xx xy xz yy yz zz.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct S4(pub(super) [X4; 6]);

impl S4 {
    #[inline(always)]
    pub(super) fn load(from: &[f64], stride: usize, at: usize) -> Self {
        let row = |k: usize| X4::load(from, k * stride + at);
        Self([row(0), row(1), row(2), row(3), row(4), row(5)])
    }

    #[inline(always)]
    pub(super) fn trace(self) -> X4 {
        self.0[0] + self.0[3] + self.0[5]
    }

    #[inline(always)]
    pub(super) fn times(self, v: V4) -> V4 {
        let (m, v) = (self.0, v.0);
        V4([
            m[0] * v[0] + m[1] * v[1] + m[2] * v[2],
            m[1] * v[0] + m[3] * v[1] + m[4] * v[2],
            m[2] * v[0] + m[4] * v[1] + m[5] * v[2],
        ])
    }

    /// The adjugate and the determinant.
    #[inline(always)]
    pub(super) fn adjugate(self) -> (Self, X4) {
        let m = self.0;
        let a = [
            m[3] * m[5] - m[4] * m[4],
            m[2] * m[4] - m[1] * m[5],
            m[1] * m[4] - m[2] * m[3],
            m[0] * m[5] - m[2] * m[2],
            m[1] * m[2] - m[0] * m[4],
            m[0] * m[3] - m[1] * m[1],
        ];
        let det = m[0] * a[0] + m[1] * a[1] + m[2] * a[2];
        (Self(a), det)
    }
}

impl Add for S4 {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        let (a, b) = (self.0, other.0);
        let row = |k: usize| a[k] + b[k];
        Self([row(0), row(1), row(2), row(3), row(4), row(5)])
    }
}
