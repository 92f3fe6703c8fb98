//! The composite of two fields at a point: what the shaders do at a joint.

use glam::Vec3;

use super::{Operator, TABLE, Volume};

/// A gradient shorter than this has no direction; its unit is 1 / (the length in which positions are given).
pub const NULL_GRADIENT: f32 = 1e-6;

/// A field's value and gradient at a point, both fields' gradients in the same space.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sample {
    /// f in [0, 1].
    pub value: f32,
    /// ∇f.
    pub gradient: Vec3,
}

/// The sample of greater value, `a` where they are equal (Eq. 3).
pub fn union(a: Sample, b: Sample) -> Sample {
    if b.value > a.value { b } else { a }
}

/// Composite of a joint's field with its parent's: g(f1, f2, tan θ(α)) and ∂g/∂f1 ∇f1 + ∂g/∂f2 ∇f2.
///
/// The derivative of θ is left out, as the authors do. Where a field is 0 or a gradient has no direction the angle α is undefined
/// and the result is the union. `opening` is the table of the joint's curve and `volume` its operator; the union uses neither.
pub fn evaluate(
    child: Sample,
    parent: Sample,
    operator: Operator,
    opening: &[f32; TABLE],
    volume: &Volume,
) -> Sample {
    let lengths = [child.gradient.length(), parent.gradient.length()];
    if operator == Operator::Union
        || child.value.min(parent.value) <= 0.0
        || lengths[0].min(lengths[1]) < NULL_GRADIENT
    {
        return union(child, parent);
    }
    let cos = child.gradient.dot(parent.gradient) / (lengths[0] * lengths[1]);
    let [value, by_first, by_second] =
        volume.sample(child.value, parent.value, lookup(opening, cos));
    Sample {
        value,
        gradient: by_first * child.gradient + by_second * parent.gradient,
    }
}

/// tan θ from an opening curve's table, linear between entries.
fn lookup(opening: &[f32; TABLE], cos: f32) -> f32 {
    let x = (cos.clamp(-1.0, 1.0) * 0.5 + 0.5) * (TABLE - 1) as f32;
    let i = (x as usize).min(TABLE - 2);
    opening[i] + (opening[i + 1] - opening[i]) * (x - i as f32)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::{
        super::{OpeningCurve, blend, volume},
        *,
    };

    fn sample(value: f32, gradient: Vec3) -> Sample {
        Sample { value, gradient }
    }

    #[test]
    fn gradients_at_45_degrees_blend_and_parallel_ones_do_not() {
        let (table, blends) = (OpeningCurve::elbow().table(), volume(Operator::Blend, 1.0));
        let at = |b: Vec3| {
            let (a, b) = (sample(0.4, -Vec3::X), sample(0.35, b));
            evaluate(a, b, Operator::Blend, &table, &blends)
        };
        let bent = at(-Vec3::new(1.0, 1.0, 0.0));
        let exact = blend(0.4, 0.35, 0.0);
        assert!((bent.value as f64 - exact.value).abs() < 3e-3, "{bent:?}");
        let expected = Vec3::new(
            (exact.by_first + exact.by_second) as f32,
            exact.by_second as f32,
            0.0,
        );
        assert!((bent.gradient + expected).length() < 0.03, "{bent:?}");
        assert!((at(-Vec3::X).value - 0.4).abs() < 2e-3);
    }

    #[test]
    fn an_undefined_angle_is_the_union() {
        let (table, blends) = (OpeningCurve::elbow().table(), volume(Operator::Blend, 1.0));
        let (a, b) = (sample(0.4, Vec3::ZERO), sample(0.45, Vec3::Y));
        assert_eq!(evaluate(a, b, Operator::Blend, &table, &blends), b);
        let (a, none) = (sample(0.4, Vec3::Y), sample(0.0, Vec3::X));
        assert_eq!(evaluate(a, none, Operator::Blend, &table, &blends), a);
    }
}
