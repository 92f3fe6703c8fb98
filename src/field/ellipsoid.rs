//! The field of an extra primitive: an ellipsoid, as an HRBF like every part's (2014, section 6.2).

use std::f64::consts::PI;

use glam::{DMat3, DVec3, Mat3, Vec3};

use super::{Field, FieldBox, bounds::bounds, hrbf::Constraint, hrbf::Hrbf};

/// Samples on an ellipsoid that is as wide as it is long, and on any.
const FEWEST_SAMPLES: f64 = 60.0;
const MOST_SAMPLES: f64 = 240.0;
/// Angle between two samples that follow each other on a spiral over a sphere.
const GOLDEN: f64 = PI * (3.0 - 2.236_067_977_499_79);

impl Field {
    /// The field of an ellipsoid whose axis goes from `start` to `end`, with `radius` across it, carried by a joint: all in
    /// rest space and rest units. 0.5 on its surface, 0 from a further `radius` on.
    ///
    /// None where no function can be fitted, as to an ellipsoid without length or width.
    pub fn ellipsoid(joint: u16, start: Vec3, end: Vec3, radius: f32) -> Option<Self> {
        let samples = samples(start.as_dvec3(), end.as_dvec3(), f64::from(radius))?;
        let points: Vec<DVec3> = samples.iter().map(|s| s.position).collect();
        let mut field = Self {
            joint,
            segments: vec![[start, end]],
            radius,
            bounds: FieldBox {
                origin: Vec3::ZERO,
                axes: Mat3::IDENTITY,
                size: Vec3::ONE,
            },
            hrbf: Hrbf::solve(&samples)?,
        };
        field.bounds = bounds(&field, &points);
        Some(field)
    }
}

/// Points evenly spread over a sphere and stretched to the ellipsoid, with its normals; a longer one has more.
fn samples(start: DVec3, end: DVec3, radius: f64) -> Option<Vec<Constraint>> {
    let x = (end - start).try_normalize()?;
    let (y, z) = x.any_orthonormal_pair();
    let axes = DMat3::from_cols(x, y, z);
    let (middle, half) = (0.5 * (start + end), 0.5 * start.distance(end));
    let size = DVec3::new(half, radius, radius);
    let slender = (half / radius).max(radius / half);
    let count = (FEWEST_SAMPLES * slender).clamp(FEWEST_SAMPLES, MOST_SAMPLES) as usize;
    let sample = |i: usize| {
        let along = 1.0 - (2 * i + 1) as f64 / count as f64;
        let (b, a) = (GOLDEN * i as f64).sin_cos();
        let across = (1.0 - along * along).sqrt();
        let unit = DVec3::new(along, across * a, across * b);
        Constraint {
            position: middle + axes * (unit * size),
            value: 0.0,
            normal: axes * (unit / size).normalize(),
        }
    };
    Some((0..count).map(sample).collect())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    const START: Vec3 = Vec3::new(2.0, -1.0, 0.5);

    fn axes(end: Vec3) -> Mat3 {
        let x = (end - START).normalize();
        let (y, z) = x.any_orthonormal_pair();
        Mat3::from_cols(x, y, z)
    }

    fn size(end: Vec3, radius: f32) -> Vec3 {
        Vec3::new(0.5 * START.distance(end), radius, radius)
    }

    /// Point of an ellipsoid at shares of its half axes.
    fn point(end: Vec3, radius: f32, unit: Vec3) -> Vec3 {
        0.5 * (START + end) + axes(end) * (unit * size(end, radius))
    }

    fn normal(end: Vec3, radius: f32, unit: Vec3) -> Vec3 {
        axes(end) * (unit / size(end, radius)).normalize()
    }

    /// Directions all round, ends included.
    fn round() -> impl Iterator<Item = Vec3> {
        let ring = |i: usize, along: f32| {
            let (b, a) = (i as f32 * 0.7).sin_cos();
            let across = (1.0 - along * along).max(0.0).sqrt();
            Vec3::new(along, across * a, across * b)
        };
        (0..=20).flat_map(move |k| (0..9).map(move |i| ring(i, k as f32 / 10.0 - 1.0)))
    }

    #[test]
    fn it_is_half_on_its_surface_more_inside_and_nothing_a_radius_outside() {
        let shapes = [(0.25, 0.125), (0.25, 0.05), (0.3, 0.02), (0.1, 0.1)];
        for (length, radius) in shapes {
            let end = START + length * Vec3::new(2.0, 1.0, -2.0) / 3.0;
            let field = Field::ellipsoid(3, START, end, radius).unwrap();
            assert_eq!((field.joint, field.radius), (3, radius));
            let f = |unit| field.evaluate(point(end, radius, unit)).0;
            for unit in round() {
                let [inside, on, outside] = [0.6, 1.0, 1.3].map(|s| f(s * unit));
                assert!((on - 0.5).abs() < 0.02, "{length} {radius} {unit}: {on}");
                assert!(inside > 0.55 && outside < 0.45, "{length} {radius} {unit}");
                let on = point(end, radius, unit);
                let far = on + 2.001 * radius * normal(end, radius, unit);
                assert_eq!(field.evaluate(far).0, 0.0, "{length} {radius} {unit}");
            }
        }
    }

    #[test]
    fn its_box_holds_all_of_it_and_little_else() {
        let end = START + Vec3::new(0.0, 0.2, 0.0);
        let field = Field::ellipsoid(0, START, end, 0.04).unwrap();
        let from_rest = field.bounds.from_rest();
        for unit in round() {
            let at = from_rest.transform_point3(point(end, 0.04, 1.05 * unit));
            assert_eq!(at, at.clamp(Vec3::ZERO, Vec3::ONE), "{unit}");
        }
        assert!(field.bounds.size.max_element() < 0.2 + 4.0 * 0.04 + 1e-5);
        assert!(field.bounds.axes.col(0).dot(Vec3::Y) > 0.999);
    }

    #[test]
    fn without_length_or_width_there_is_none() {
        assert!(Field::ellipsoid(0, START, START, 1.0).is_none());
        assert!(Field::ellipsoid(0, START, START + Vec3::X, 0.0).is_none());
    }
}
