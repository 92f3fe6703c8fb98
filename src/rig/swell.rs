//! Extra primitives as a rig has them: their fields, and how they swell with a joint's bend (2014, section 6.2).

use glam::{Mat3, Mat4, Vec3};

use super::{Pose, Primitive, Rig, Skeleton};
use crate::{
    Error, Result,
    compose::Composition,
    field::{Field, MAX_FIELDS},
};

/// An extra primitive of a rig.
#[derive(Clone, Debug, PartialEq)]
pub struct Swell {
    /// Its name.
    pub name: String,
    /// Row of the joint that carries it.
    pub joint: usize,
    /// Row of the joint whose bend swells it.
    pub driver: usize,
    /// Its centre in rest space.
    pub centre: Vec3,
    /// Its axis, a unit vector of rest space.
    pub axis: Vec3,
    /// Greatest distance from its centre that its field reaches, in rest units.
    pub reach: f32,
    /// Bends in degrees between which it swells, ascending.
    pub degrees: [f32; 2],
    /// Its scales at these bends.
    pub stretch: [Stretch; 2],
}

/// Scales of a primitive about its centre.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stretch {
    /// Across its axis.
    pub across: f32,
    /// Along its axis.
    pub along: f32,
}

impl Swell {
    /// The scales at a bend in degrees: in proportion to the bend within the range (2014, figure 10), fixed outside.
    pub fn stretch(&self, bend: f32) -> Stretch {
        let [first, last] = self.degrees;
        let share = ((bend - first) / (last - first)).clamp(0.0, 1.0);
        let [a, b] = self.stretch;
        let mix = |a: f32, b: f32| a + (b - a) * share;
        Stretch {
            across: mix(a.across, b.across),
            along: mix(a.along, b.along),
        }
    }

    /// The scales in a pose.
    pub fn stretch_in(&self, skeleton: &Skeleton, pose: &Pose) -> Stretch {
        self.stretch(pose.bend(skeleton, self.driver))
    }

    /// The scales at a bend as a matrix, rest → rest space.
    pub fn matrix(&self, stretch: Stretch) -> Mat4 {
        let a = self.axis;
        let along = Mat3::from_cols(a * a.x, a * a.y, a * a.z);
        let linear = Mat3::from_diagonal(Vec3::splat(stretch.across))
            + along * (stretch.along - stretch.across);
        let shift = self.centre - linear * self.centre;
        Mat4::from_translation(shift) * Mat4::from_mat3(linear)
    }

    /// Whether its own shape in a pose is not that in another, none being rest, by more than `still` in rest units.
    pub(crate) fn changes(
        &self,
        skeleton: &Skeleton,
        before: Option<&Pose>,
        pose: &Pose,
        still: f32,
    ) -> bool {
        let a = before.map_or(self.stretch(0.0), |p| self.stretch_in(skeleton, p));
        let b = self.stretch_in(skeleton, pose);
        let most = (a.across - b.across).abs().max((a.along - b.along).abs());
        most * self.reach > still
    }
}

impl Rig {
    /// The primitive that a field is of; none for the field of a joint's part.
    pub fn primitive(&self, field: usize) -> Option<&Swell> {
        let first = self.fields.len() - self.primitives.len();
        field
            .checked_sub(first)
            .and_then(|k| self.primitives.get(k))
    }
}

/// Appends the fields of checked primitives and composes them with those of their joints.
///
/// # Errors
/// [`Error::Primitive`] where neither the joint nor one above it has a field, or no function can be fitted;
/// [`Error::Argument`] for more fields than the passes know.
pub(super) fn add(
    list: &[Primitive],
    skeleton: &Skeleton,
    fields: &mut Vec<Field>,
    composition: &mut Composition,
) -> Result<Vec<Swell>> {
    if !list.is_empty() && fields.len() + list.len() > MAX_FIELDS {
        let (n, m) = (list.len(), fields.len());
        let reason = format!("{n} and {m} fields of joints; at most {MAX_FIELDS} fit");
        return Err(Error::argument("primitives", reason));
    }
    let of_joints: Vec<usize> = fields.iter().map(|f| usize::from(f.joint)).collect();
    list.iter()
        .map(|primitive| {
            let joint = skeleton.find(&primitive.joint)?;
            let parent = nearest(skeleton, &of_joints, joint).ok_or_else(|| {
                let name = &primitive.joint;
                primitive.wrong(
                    "joint",
                    format!("neither {name:?} nor a joint above it has a field"),
                )
            })?;
            let (field, swell) = fit(primitive, skeleton, joint)?;
            fields.push(field);
            composition.add_primitive(parent);
            Ok(swell)
        })
        .collect()
}

/// Field of a joint or of the nearest one above it.
fn nearest(skeleton: &Skeleton, of_joints: &[usize], joint: usize) -> Option<u32> {
    let mut at = Some(joint);
    while let Some(joint) = at {
        if let Some(row) = of_joints.iter().position(|j| *j == joint) {
            return Some(row as u32);
        }
        at = skeleton.joints[joint].parent;
    }
    None
}

fn fit(primitive: &Primitive, skeleton: &Skeleton, joint: usize) -> Result<(Field, Swell)> {
    // Lengths are those of the file, whatever the scale of the joint.
    let (_, turn, origin) = skeleton.joints[joint].bind.to_scale_rotation_translation();
    let to_rest = |p: [f32; 3]| origin + turn * Vec3::from(p);
    let (start, end) = (to_rest(primitive.start), to_rest(primitive.end));
    let field = Field::ellipsoid(joint as u16, start, end, primitive.radius).ok_or_else(|| {
        primitive.wrong(
            "radius",
            "no ellipsoid of this length and radius can be fitted",
        )
    })?;
    let [a, b] = primitive.scale;
    let swell = Swell {
        name: primitive.name.clone(),
        joint,
        driver: skeleton.find(&primitive.driver)?,
        centre: 0.5 * (start + end),
        axis: (end - start).normalize_or(Vec3::X),
        reach: 0.5 * field.bounds.size.length(),
        degrees: primitive.degrees,
        stretch: [
            Stretch {
                across: a,
                along: 1.0,
            },
            Stretch {
                across: b,
                along: primitive.along.unwrap_or(1.0),
            },
        ],
    };
    Ok((field, swell))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::{
        compose::Operator,
        rig::{Options, primitive::tests::biceps, program::compose, skeleton::tests::skeleton},
    };

    fn swell(change: fn(&mut Primitive)) -> Swell {
        let mut primitive = biceps();
        change(&mut primitive);
        fit(&primitive, &skeleton(), 0).unwrap().1
    }

    fn bent(degrees: f32) -> Pose {
        let turn = Mat4::from_rotation_z(degrees.to_radians());
        let still = Mat4::IDENTITY;
        Pose::from_local(&skeleton(), &[still, turn, still, still]).unwrap()
    }

    #[test]
    fn the_scale_goes_with_the_bend_and_stops_at_both_ends() {
        let swell = swell(|p| {
            p.degrees = [20.0, 120.0];
            p.scale = [0.8, 1.6];
            p.along = Some(0.9);
        });
        let cases = [
            (0.0, 0.8),
            (20.0, 0.8),
            (70.0, 1.2),
            (120.0, 1.6),
            (170.0, 1.6),
        ];
        for (bend, across) in cases {
            for sign in [1.0, -1.0] {
                let s = swell.stretch_in(&skeleton(), &bent(sign * bend));
                assert!((s.across - across).abs() < 1e-4, "{bend}: {s:?}");
                let along = 1.0 - 0.1 * (across - 0.8) / 0.8;
                assert!((s.along - along).abs() < 1e-4, "{bend}: {s:?}");
            }
        }
        let rest = swell.stretch_in(&skeleton(), &Pose::rest(&skeleton()));
        assert_eq!(rest, swell.stretch[0]);
    }

    #[test]
    fn it_is_scaled_about_its_centre_across_its_axis() {
        let swell = swell(|p| p.end = [0.8, 0.4, 0.1]);
        let m = swell.matrix(Stretch {
            across: 1.5,
            along: 0.9,
        });
        let side = swell.axis.any_orthonormal_vector();
        let carried = |v: Vec3| m.transform_point3(swell.centre + v) - swell.centre;
        assert!(carried(Vec3::ZERO).length() < 1e-6);
        assert!(carried(swell.axis).distance(0.9 * swell.axis) < 1e-6);
        assert!(carried(side).distance(1.5 * side) < 1e-6);
        let one = Stretch {
            across: 1.0,
            along: 1.0,
        };
        assert_eq!(swell.matrix(one), Mat4::IDENTITY);
    }

    #[test]
    fn a_change_is_one_of_its_own_shape_alone() {
        let (swell, s) = (swell(|_| {}), skeleton());
        let changes = |before: Option<&Pose>, pose: &Pose| swell.changes(&s, before, pose, 1e-6);
        let turned = |pose: &Pose| Pose {
            matrices: pose
                .matrices
                .iter()
                .map(|m| Mat4::from_rotation_y(1.0) * *m)
                .collect(),
        };
        let rest = Pose::rest(&s);
        assert!(!changes(None, &rest) && !changes(None, &turned(&rest)));
        assert!(changes(None, &bent(30.0)) && changes(Some(&bent(30.0)), &bent(31.0)));
        let there = turned(&bent(30.0));
        assert!(!swell.changes(&s, Some(&bent(30.0)), &there, 1e-5));
        assert!(!changes(Some(&bent(130.0)), &bent(150.0)));
    }

    #[test]
    fn its_field_follows_those_of_the_joints_and_melts_into_the_nearest() {
        let s = skeleton();
        let mut fields = vec![fit(&biceps(), &s, 0).unwrap().0];
        let mut composition = compose(&s, &fields, &Options::default()).unwrap();
        let on_hand = Primitive {
            joint: "hand".into(),
            ..biceps()
        };
        let swells = add(&[on_hand], &s, &mut fields, &mut composition).unwrap();
        assert_eq!((fields.len(), fields[1].joint), (2, 2));
        assert_eq!(composition.parent, [u32::MAX, 0]);
        assert_eq!(composition.operator, [None, Some(Operator::Union)]);
        assert!(composition.is_primitive(1) && !composition.is_primitive(0));
        // The hand is at x = 2, turned by half a radian about z.
        let centre =
            Vec3::new(2.0, 0.0, 0.0) + Mat3::from_rotation_z(0.5) * Vec3::new(0.5, 0.1, 0.0);
        assert!(swells[0].centre.distance(centre) < 1e-6);
        let rig = Rig {
            fields,
            primitives: swells,
            ..Rig::default()
        };
        assert!(rig.primitive(0).is_none() && rig.primitive(2).is_none());
        assert_eq!(rig.primitive(1).unwrap().joint, 2);
    }

    #[test]
    fn without_a_field_above_or_with_too_many_it_is_refused() {
        let s = skeleton();
        let (tail, _) = fit(&biceps(), &s, 3).unwrap();
        let refused = |mut fields: Vec<Field>| {
            let mut composition = Composition::default();
            let refused = add(&[biceps()], &s, &mut fields, &mut composition);
            refused.unwrap_err().to_string()
        };
        let error = refused(vec![tail.clone()]);
        assert!(
            error.contains("biceps") && error.contains("joint"),
            "{error}"
        );
        let error = refused(vec![tail; MAX_FIELDS]);
        assert!(error.starts_with("primitives: 1 and 255 fields"), "{error}");
    }
}
