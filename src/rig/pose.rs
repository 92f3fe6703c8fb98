//! Poses: one matrix a joint that carries rest space to model space.

use glam::{Mat4, Quat};

use super::{Pose, Random, Skeleton};
use crate::{Error, Result};

/// Least determinant of a usable matrix, as a share of the product of its column lengths' bound.
const SINGULAR: f64 = 1e-9;

impl Clone for Pose {
    fn clone(&self) -> Self {
        let matrices = self.matrices.clone();
        Self { matrices }
    }

    /// Keeps the memory that this pose has.
    fn clone_from(&mut self, other: &Self) {
        self.matrices.clone_from(&other.matrices);
    }
}

impl Pose {
    /// The rest pose: every matrix is the identity.
    pub fn rest(skeleton: &Skeleton) -> Self {
        Self {
            matrices: vec![Mat4::IDENTITY; skeleton.joints.len()],
        }
    }

    /// Becomes the rest pose, in the memory that it has.
    pub(crate) fn put_rest(&mut self, skeleton: &Skeleton) {
        self.matrices.clear();
        self.matrices.resize(skeleton.joints.len(), Mat4::IDENTITY);
    }

    /// Composes transforms of the joints in their own frames: G'_j = G'_parent · (bind_parent⁻¹ bind_j) · local_j, and
    /// the pose's matrix is G'_j · bind_j⁻¹. Identities give the rest pose.
    ///
    /// # Errors
    /// [`Error::Pose`] where `local` has not one matrix a joint, or a result is not finite and invertible.
    pub fn from_local(skeleton: &Skeleton, local: &[Mat4]) -> Result<Self> {
        let count = skeleton.joints.len();
        if local.len() != count {
            return Err(count_error(local.len(), count));
        }
        let mut pose = Self::rest(skeleton);
        for (j, joint) in skeleton.joints.iter().enumerate() {
            // With T = G' bind⁻¹, the chain reads T_j = T_parent · bind_j local_j bind_j⁻¹.
            let parent = joint.parent.map_or(Mat4::IDENTITY, |p| pose.matrices[p]);
            pose.matrices[j] = if local[j] == Mat4::IDENTITY {
                parent
            } else {
                parent * joint.bind * local[j] * joint.inverse_bind
            };
        }
        pose.validate(skeleton)?;
        Ok(pose)
    }

    /// Every joint but the roots turned about a random axis by up to `degrees`, evenly; the same for the same seed
    /// everywhere.
    ///
    /// # Errors
    /// [`Error::Argument`] where `degrees` is not finite.
    pub fn random(skeleton: &Skeleton, degrees: f32, seed: u64) -> Result<Self> {
        if !degrees.is_finite() {
            return Err(Error::argument(
                "degrees",
                format!("{degrees} is not finite"),
            ));
        }
        let mut random = Random::new(seed);
        let local: Vec<Mat4> = skeleton
            .joints
            .iter()
            .map(|joint| {
                let axis = random.direction();
                let angle = (random.unit() as f32 * degrees).to_radians();
                match joint.parent {
                    Some(_) => Mat4::from_quat(Quat::from_axis_angle(axis, angle)),
                    None => Mat4::IDENTITY,
                }
            })
            .collect();
        Self::from_local(skeleton, &local)
    }

    /// Angle by which a joint is rotated against its parent since rest, in degrees from 0 to 180; 0 for a joint without parent.
    pub fn bend(&self, skeleton: &Skeleton, joint: usize) -> f32 {
        match skeleton.joints[joint].parent {
            Some(parent) => degrees(&(self.matrices[parent].inverse() * self.matrices[joint])),
            None => 0.0,
        }
    }

    /// Checks that there is one matrix a joint, each finite, affine and invertible.
    ///
    /// # Errors
    /// [`Error::Pose`] naming the first joint that fails.
    pub fn validate(&self, skeleton: &Skeleton) -> Result<()> {
        let count = skeleton.joints.len();
        if self.matrices.len() != count {
            return Err(count_error(self.matrices.len(), count));
        }
        for (joint, matrix) in skeleton.joints.iter().zip(&self.matrices) {
            check(matrix).map_err(|reason| Error::Pose {
                element: format!("joint {:?}", joint.name),
                reason: reason.into(),
            })?;
        }
        Ok(())
    }
}

/// Angle of the rotation of a matrix.
pub(crate) fn degrees(m: &Mat4) -> f32 {
    let (_, rotation, _) = m.to_scale_rotation_translation();
    // The arc cosine of w is blind to small angles.
    let half = rotation.xyz().length().atan2(rotation.w.abs());
    (2.0 * half).to_degrees()
}

fn count_error(given: usize, wanted: usize) -> Error {
    Error::Pose {
        element: "matrices".into(),
        reason: format!("{given} given, the character has {wanted} joints"),
    }
}

/// Why a matrix cannot carry a joint.
fn check(matrix: &Mat4) -> Result<(), &'static str> {
    if !matrix.is_finite() {
        return Err("a number is not finite");
    }
    let bottom = matrix.row(3);
    // Inverses and products round.
    if bottom.truncate().abs().max_element() > 1e-4 || (bottom.w - 1.0).abs() > 1e-4 {
        return Err("the matrix is not affine");
    }
    let linear = glam::DMat3::from_cols(
        matrix.x_axis.truncate().as_dvec3(),
        matrix.y_axis.truncate().as_dvec3(),
        matrix.z_axis.truncate().as_dvec3(),
    );
    let longest = [linear.x_axis, linear.y_axis, linear.z_axis]
        .map(|c| c.length())
        .into_iter()
        .fold(0.0, f64::max);
    let bound = longest * longest * longest;
    if linear.determinant().abs() <= SINGULAR * bound || !matrix.inverse().is_finite() {
        return Err("the matrix has no inverse");
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use glam::Vec3;

    use super::*;
    use crate::rig::skeleton::tests::skeleton;

    #[test]
    fn bending_a_joint_turns_its_descendants_about_its_origin() {
        let s = skeleton();
        let mut local = [Mat4::IDENTITY; 4];
        local[1] = Mat4::from_rotation_z(std::f32::consts::FRAC_PI_2);
        let pose = Pose::from_local(&s, &local).unwrap();
        let moved = |j: usize, p| pose.matrices[j].transform_point3(p);
        assert_eq!(pose.matrices[0], Mat4::IDENTITY);
        assert!(moved(1, Vec3::X).distance(Vec3::X) < 1e-6);
        assert!(moved(2, 2.0 * Vec3::X).distance(Vec3::new(1.0, 1.0, 0.0)) < 1e-6);
        assert_eq!(pose.matrices[3], Mat4::IDENTITY);
    }

    #[test]
    fn random_poses_repeat_stay_within_the_angle_and_leave_roots() {
        let s = skeleton();
        let pose = Pose::random(&s, 60.0, 7).unwrap();
        assert_eq!(pose, Pose::random(&s, 60.0, 7).unwrap());
        assert_ne!(pose, Pose::random(&s, 60.0, 8).unwrap());
        assert_eq!(pose.matrices[0], Mat4::IDENTITY);
        for seed in 0..50 {
            let pose = Pose::random(&s, 60.0, seed).unwrap();
            let angle = Quat::from_mat4(&pose.matrices[1]).to_axis_angle().1;
            assert!(angle <= 60.1f32.to_radians(), "{angle}");
        }
        assert!(Pose::random(&s, f32::NAN, 0).is_err());
    }

    #[test]
    fn unusable_matrices_are_refused_by_joint() {
        let s = skeleton();
        let refused = |matrix| {
            let mut pose = Pose::rest(&s);
            pose.matrices[2] = matrix;
            pose.validate(&s).unwrap_err().to_string()
        };
        for matrix in [
            Mat4::from_scale(Vec3::new(1.0, 1.0, 0.0)),
            Mat4::from_translation(Vec3::splat(f32::NAN)),
            Mat4::from_scale(Vec3::splat(f32::INFINITY)),
            Mat4::IDENTITY.transpose() * 2.0,
        ] {
            assert!(refused(matrix).contains("hand"), "{matrix}");
        }
        let short = Pose {
            matrices: vec![Mat4::IDENTITY; 3],
        };
        assert!(short.validate(&s).is_err());
        let small_and_mirrored = Pose {
            matrices: vec![Mat4::from_scale(Vec3::new(-1e-4, 1e-4, 1e-4)); 4],
        };
        small_and_mirrored.validate(&s).unwrap();
    }
}
