//! Poses between two poses.

use glam::{Mat4, Quat, Vec3};

use super::{Pose, Skeleton};
use crate::{Error, Result};

impl Pose {
    /// The pose at `t` in [0, 1] from `a` to `b`: every joint turns along the shortest arc in its parent's frame, its
    /// translation and scale change evenly. `t` = 0 and 1 answer `a` and `b` bit for bit.
    ///
    /// A shear in a joint's frame is lost in between.
    ///
    /// # Errors
    /// [`Error::Pose`] where `a` or `b` does not belong to the skeleton or is not finite and invertible;
    /// [`Error::Argument`] for `t` outside [0, 1].
    pub fn interpolate(skeleton: &Skeleton, a: &Self, b: &Self, t: f32) -> Result<Self> {
        a.validate(skeleton)?;
        b.validate(skeleton)?;
        if !(0.0..=1.0).contains(&t) {
            return Err(Error::argument("t", format!("{t} is not in 0 to 1")));
        }
        let mut pose = Self::default();
        pose.put_between(skeleton, a, b, t)?;
        Ok(pose)
    }

    /// [`Pose::interpolate`] of valid poses, into the memory that this one has.
    pub(crate) fn put_between(
        &mut self,
        skeleton: &Skeleton,
        a: &Self,
        b: &Self,
        t: f32,
    ) -> Result<()> {
        if t == 0.0 || t == 1.0 {
            self.clone_from(if t == 0.0 { a } else { b });
            return Ok(());
        }
        let global = &mut self.matrices;
        global.clear();
        for (j, joint) in skeleton.joints.iter().enumerate() {
            let (from, to) = (local(skeleton, a, j), local(skeleton, b, j));
            let parent = joint.parent.map_or(Mat4::IDENTITY, |p| global[p]);
            global.push(parent * between(from, to, t));
        }
        for (matrix, joint) in global.iter_mut().zip(&skeleton.joints) {
            *matrix *= joint.inverse_bind;
        }
        self.validate(skeleton)
    }
}

/// Joint space → parent's joint space (model space for a root).
fn local(skeleton: &Skeleton, pose: &Pose, j: usize) -> Mat4 {
    let global = |j: usize| pose.matrices[j] * skeleton.joints[j].bind;
    match skeleton.joints[j].parent {
        Some(p) => global(p).inverse() * global(j),
        None => global(j),
    }
}

fn between(a: Mat4, b: Mat4, t: f32) -> Mat4 {
    let (s0, r0, t0) = a.to_scale_rotation_translation();
    let (s1, r1, t1) = b.to_scale_rotation_translation();
    Mat4::from_scale_rotation_translation(
        Vec3::lerp(s0, s1, t),
        Quat::slerp(r0, r1, t).normalize(),
        Vec3::lerp(t0, t1, t),
    )
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::rig::skeleton::tests::skeleton;

    #[test]
    fn half_of_a_turn_is_half_the_angle_and_limbs_keep_their_length() {
        let s = skeleton();
        let mut local = [Mat4::IDENTITY; 4];
        local[0] = Mat4::from_translation(Vec3::Y) * Mat4::from_rotation_x(1.0);
        local[1] = Mat4::from_rotation_z(2.0);
        let end = Pose::from_local(&s, &local).unwrap();
        local[0] = Mat4::from_translation(0.5 * Vec3::Y) * Mat4::from_rotation_x(0.5);
        local[1] = Mat4::from_rotation_z(1.0);
        let wanted = Pose::from_local(&s, &local).unwrap();
        let half = Pose::interpolate(&s, &Pose::rest(&s), &end, 0.5).unwrap();
        for (a, b) in half.matrices.iter().zip(&wanted.matrices) {
            assert!(a.abs_diff_eq(*b, 1e-5), "{a} {b}");
        }
    }

    #[test]
    fn ends_are_exact_and_nonsense_is_refused() {
        let s = skeleton();
        let (a, b) = (
            Pose::random(&s, 90.0, 1).unwrap(),
            Pose::random(&s, 90.0, 2).unwrap(),
        );
        assert_eq!(Pose::interpolate(&s, &a, &b, 0.0).unwrap(), a);
        assert_eq!(Pose::interpolate(&s, &a, &b, 1.0).unwrap(), b);
        assert!(Pose::interpolate(&s, &a, &b, f32::NAN).is_err());
        let none = Pose { matrices: vec![] };
        assert!(Pose::interpolate(&s, &a, &none, 0.5).is_err());
    }
}
