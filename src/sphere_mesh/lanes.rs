//! Four frames at once: plain arrays that the compiler turns into vector instructions.

use std::ops::{Add, AddAssign, Mul, Sub};

/// Frames of a group.
pub(super) const LANES: usize = 4;

/// Numbers of four frames, as they are kept.
pub(super) type Row = [f64; LANES];

/// A point in each of four frames, as it is kept: `[axis][frame]`.
pub(super) type Points = [[f32; LANES]; 3];

/// The same of two numbers in each of four frames of single precision.
#[inline(always)]
pub(super) fn zip(a: [f32; LANES], b: [f32; LANES], f: impl Fn(f32, f32) -> f32) -> [f32; LANES] {
    [f(a[0], b[0]), f(a[1], b[1]), f(a[2], b[2]), f(a[3], b[3])]
}

/// The greater of two; no instruction more than that, as neither is NaN.
#[inline(always)]
pub(super) fn most(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

/// The lesser of two, likewise.
#[inline(always)]
pub(super) fn least(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

/// One number in each of four frames.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct X4(pub(super) [f64; LANES]);

impl X4 {
    pub(super) fn splat(x: f64) -> Self {
        Self([x; LANES])
    }

    /// Of single precision.
    #[inline(always)]
    pub(super) fn widen([a, b, c, d]: [f32; LANES]) -> Self {
        Self([f64::from(a), f64::from(b), f64::from(c), f64::from(d)])
    }

    /// To single precision.
    #[inline(always)]
    pub(super) fn narrow(self) -> [f32; LANES] {
        let [a, b, c, d] = self.0;
        [a as f32, b as f32, c as f32, d as f32]
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
    #[inline(always)]
    pub(super) fn new([x, y, z]: [Row; 3]) -> Self {
        Self([X4(x), X4(y), X4(z)])
    }

    /// Of single precision.
    #[inline(always)]
    pub(super) fn widen([x, y, z]: &Points) -> Self {
        Self([X4::widen(*x), X4::widen(*y), X4::widen(*z)])
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
    pub(super) fn new([a, b, c, d, e, f]: [Row; 6]) -> Self {
        Self([X4(a), X4(b), X4(c), X4(d), X4(e), X4(f)])
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
