//! Operators sampled on 128³ half-float texels, as the shaders fetch them.

use half::f16;
use rayon::prelude::*;

use crate::{Error, Result};

use super::{Operator, Partials, blend, bulge, operator::check_magnitude, operator::union};

/// Texels along an edge of a volume.
pub const EDGE: usize = 128;

/// An operator over (f1, f2, tan θ), each axis from 0 at texel 0 to 1 at texel 127; operators by profile have the depth d in the
/// place of tan θ.
#[derive(Clone, Debug, PartialEq)]
pub struct Volume {
    /// g, ∂g/∂f1, ∂g/∂f2, 0; row `(k·128 + j)·128 + i` has f1 = i/127, f2 = j/127, tan θ = k/127.
    pub texels: Vec<[f16; 4]>,
}

/// Samples an operator of the 2013 method (those of the 2014 method are unions here, [`profile_volume`](super::profile_volume) has them); `magnitude` matters to the bulge only; one that [`check_magnitude`] refuses counts as 0.
///
/// Values are rounded down: linear interpolation across a crease errs upward, by a quarter of a cell, so the two partly cancel.
pub fn volume(operator: Operator, magnitude: f32) -> Volume {
    let magnitude = check_magnitude(magnitude).unwrap_or_default() as f64;
    let at = |i: usize| i as f64 / (EDGE - 1) as f64;
    let mut texels = vec![[f16::ZERO; 4]; EDGE * EDGE * EDGE];
    texels
        .par_chunks_mut(EDGE)
        .enumerate()
        .for_each(|(row, texels)| {
            let (f2, t) = (at(row % EDGE), at(row / EDGE));
            for (i, texel) in texels.iter_mut().enumerate() {
                let partials = match operator {
                    Operator::Union | Operator::Contact | Operator::Profile => union(at(i), f2),
                    Operator::Blend => blend(at(i), f2, t),
                    Operator::Bulge => bulge(at(i), f2, t, magnitude),
                };
                *texel = pack(partials);
            }
        });
    Volume { texels }
}

/// Half floats of one texel.
fn pack(p: Partials) -> [f16; 4] {
    let nearest = f16::from_f64(p.value);
    let above = nearest.to_f64() > p.value;
    let value = f16::from_bits(nearest.to_bits() - u16::from(above));
    [
        value,
        f16::from_f64(p.by_first),
        f16::from_f64(p.by_second),
        f16::ZERO,
    ]
}

impl Volume {
    /// The texels' bytes in upload order, 8 a texel.
    pub fn bytes(&self) -> &[u8] {
        bytemuck::cast_slice(&self.texels)
    }

    /// A volume from the bytes of another, as a cache keeps them.
    ///
    /// # Errors
    /// [`Error::Argument`] with subject `volume` where the number of bytes is not 8 · 128³.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self> {
        let mut texels = vec![[f16::ZERO; 4]; EDGE * EDGE * EDGE];
        let target: &mut [u8] = bytemuck::cast_slice_mut(&mut texels);
        if bytes.len() != target.len() {
            let reason = format!("{} bytes instead of {}", bytes.len(), target.len());
            return Err(Error::argument("volume", reason));
        }
        target.copy_from_slice(bytes);
        Ok(Self { texels })
    }

    /// g, ∂g/∂f1, ∂g/∂f2 by linear filtering, clamped to the edges: what a sampler returns at texture coordinates (127 f + 0.5) / 128.
    pub fn sample(&self, f1: f32, f2: f32, tan_theta: f32) -> [f32; 3] {
        let place = |f: f32| {
            let x = f.clamp(0.0, 1.0) * (EDGE - 1) as f32;
            let i = (x as usize).min(EDGE - 2);
            (i, x - i as f32)
        };
        let ((i, u), (j, v), (k, w)) = (place(f1), place(f2), place(tan_theta));
        let lerp = |a: [f32; 3], b: [f32; 3], s: f32| -> [f32; 3] {
            std::array::from_fn(|c| a[c] + (b[c] - a[c]) * s)
        };
        let texel = |i: usize, j: usize, k: usize| -> [f32; 3] {
            let t = &self.texels[(k * EDGE + j) * EDGE + i];
            std::array::from_fn(|c| t[c].to_f32())
        };
        let row = |j: usize, k: usize| lerp(texel(i, j, k), texel(i + 1, j, k), u);
        let slice = |k: usize| lerp(row(j, k), row(j + 1, k), v);
        lerp(slice(k), slice(k + 1), w)
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn worst(volume: &Volume, exact: impl Fn(f64, f64, f64) -> Partials) -> f64 {
        let mut worst: f64 = 0.0;
        for i in 1..=100_000 {
            let [a, b, t] = [0.819_172_513_396, 0.671_043_606_704, 0.549_700_477_901]
                .map(|a: f64| (0.5 + a * i as f64).fract());
            // Every second point lies close to the crease f1 = f2, where interpolation is worst.
            let b = if i % 2 == 0 {
                (a + (b - 0.5) / 64.0).clamp(0.0, 1.0)
            } else {
                b
            };
            let sampled = volume.sample(a as f32, b as f32, t as f32)[0] as f64;
            worst = worst.max((sampled - exact(a, b, t).value).abs());
        }
        worst
    }

    #[test]
    fn union_and_blend_volumes_are_within_2e_3_of_the_closed_form() {
        let (unions, blends) = (volume(Operator::Union, 1.0), volume(Operator::Blend, 1.0));
        let error = worst(&unions, |a, b, _| union(a, b));
        assert!(error < 2e-3, "union {error:e}");
        let error = worst(&blends, blend);
        assert!(error < 2e-3, "blend {error:e}");
        assert!(
            worst(&unions, blend) > 0.1,
            "a wrong volume must be noticed"
        );
    }

    #[test]
    fn a_bulge_volume_is_close_to_its_operator_and_obeys_the_magnitude() {
        let bulges = volume(Operator::Bulge, 1.0);
        // 3e-3: the crease on the diagonal is sharper than the union's by the bulge.
        let error = worst(&bulges, |a, b, t| bulge(a, b, t, 1.0));
        assert!(error < 3e-3, "{error:e}");
        assert!(worst(&bulges, |a, b, t| bulge(a, b, t, 1.5)) > 0.01);
    }

    #[test]
    fn texels_are_the_samples_of_the_operator() {
        let blends = volume(Operator::Blend, 1.0);
        assert_eq!(blends.bytes().len(), 128 * 128 * 128 * 8);
        assert_eq!(Volume::from_bytes(blends.bytes()).unwrap(), blends);
        assert!(Volume::from_bytes(&blends.bytes()[1..]).is_err());
        for (i, j, k) in [
            (0, 90, 3),
            (90, 0, 127),
            (50, 40, 0),
            (40, 50, 64),
            (127, 127, 127),
        ] {
            let at = |i: usize| i as f64 / 127.0;
            let exact = blend(at(i), at(j), at(k));
            let [g, first, second] = blends.sample(at(i) as f32, at(j) as f32, at(k) as f32);
            assert!((g as f64 - exact.value).abs() < 5e-4, "{i} {j} {k}");
            assert!((first as f64 - exact.by_first).abs() < 1e-3, "{i} {j} {k}");
            assert!(
                (second as f64 - exact.by_second).abs() < 1e-3,
                "{i} {j} {k}"
            );
        }
    }
}
