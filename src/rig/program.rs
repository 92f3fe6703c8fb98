//! How a rig's fields meet: the nearest ancestor with a field, and the operator chosen at the joint between.

use super::{Options, Skeleton};
use crate::{
    Error, Result,
    compose::{Composition, Operator, check_magnitude},
    field::Field,
};

/// The composition of the fields with the operators and opening curves that the options name.
///
/// # Errors
/// [`Error::Joint`] for a joint that the skeleton has not or that carries no field; [`Error::Argument`] for a magnitude
/// out of range.
pub(super) fn compose(
    skeleton: &Skeleton,
    fields: &[Field],
    options: &Options,
) -> Result<Composition> {
    check_magnitude(options.magnitude)?;
    let field_of = |joint: usize| fields.iter().position(|f| usize::from(f.joint) == joint);
    let find = |name: &str| {
        field_of(skeleton.find(name)?).ok_or_else(|| Error::Joint {
            joint: name.into(),
            reason: "it has too little skin for a field of its own".into(),
        })
    };
    let parent = |field: &Field| {
        let mut at = skeleton.joints[usize::from(field.joint)].parent;
        while let Some(joint) = at {
            if let Some(row) = field_of(joint) {
                return row as u32;
            }
            at = skeleton.joints[joint].parent;
        }
        u32::MAX
    };
    let mut composition = Composition {
        parent: fields.iter().map(parent).collect(),
        primitives: 0,
        operator: vec![None; fields.len()],
        opening: vec![None; fields.len()],
        controller: vec![None; fields.len()],
        profile: options.profile.clone(),
        magnitude: options.magnitude,
    };
    for (name, operator) in &options.joints {
        if *operator == Operator::Profile && options.profile.is_none() {
            return Err(Error::Joint {
                joint: name.clone(),
                reason: "its operator is a profile, but none is given".into(),
            });
        }
        composition.operator[find(name)?] = Some(*operator);
    }
    for (name, opening) in &options.openings {
        composition.opening[find(name)?] = Some(*opening);
    }
    for (name, controller) in &options.controllers {
        composition.controller[find(name)?] = Some(*controller);
    }
    Ok(composition)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::{
        compose::OpeningCurve,
        field::{FieldBox, Hrbf},
        rig::skeleton::tests::skeleton,
    };
    use glam::{Mat3, Vec3};

    fn fields(joints: &[u16]) -> Vec<Field> {
        let field = |&joint| Field {
            joint,
            segments: vec![],
            radius: 1.0,
            bounds: FieldBox {
                origin: Vec3::ZERO,
                axes: Mat3::IDENTITY,
                size: Vec3::ONE,
            },
            hrbf: Hrbf::default(),
        };
        joints.iter().map(field).collect()
    }

    #[test]
    fn parents_skip_joints_without_field() {
        let s = skeleton();
        let c = compose(&s, &fields(&[0, 2, 3]), &Options::default()).unwrap();
        assert_eq!(c.parent, [u32::MAX, 0, 0]);
        let c = compose(&s, &fields(&[1, 2, 3]), &Options::default()).unwrap();
        assert_eq!(c.parent, [u32::MAX, 0, u32::MAX]);
        assert_eq!(c.operator, [None; 3]);
    }

    #[test]
    fn operators_and_openings_go_to_the_named_joints() {
        let curve = OpeningCurve::new([(-1.0, 0.5), (0.0, 0.2), (1.0, 1.0)], [1.0; 2]).unwrap();
        let options = Options {
            joints: vec![
                ("hand".into(), Operator::Bulge),
                ("elbow".into(), Operator::Blend),
            ],
            openings: vec![("elbow".into(), curve)],
            magnitude: 0.5,
            ..Options::default()
        };
        let c = compose(&skeleton(), &fields(&[0, 1, 2]), &options).unwrap();
        assert_eq!(
            c.operator,
            [None, Some(Operator::Blend), Some(Operator::Bulge)]
        );
        assert_eq!(c.opening, [None, Some(curve), None]);
        assert_eq!(c.magnitude, 0.5);
    }

    #[test]
    fn unknown_joints_and_wild_magnitudes_are_refused() {
        let s = skeleton();
        let with = |name: &str| Options {
            joints: vec![(name.into(), Operator::Blend)],
            ..Options::default()
        };
        let unknown = compose(&s, &fields(&[0]), &with("knee")).unwrap_err();
        assert!(matches!(&unknown, Error::Joint { joint, .. } if joint == "knee"));
        let bare = compose(&s, &fields(&[0]), &with("hand")).unwrap_err();
        assert!(bare.to_string().contains("too little skin"));
        let options = Options {
            magnitude: f32::NAN,
            ..Options::default()
        };
        assert!(compose(&s, &fields(&[0]), &options).is_err());
    }
}
