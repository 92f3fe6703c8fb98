//! The skeleton of a model and its bones.

use glam::Vec3;

use super::{Joint, Skeleton};
use crate::{Error, Result, asset::Model};

impl Skeleton {
    /// Joints of a model in its order.
    ///
    /// # Errors
    /// [`Error::Joint`] for a parent that does not precede its child, a name used twice or an inverse bind matrix that is
    /// not finite or has no inverse; [`Error::Argument`] for no joint at all or more than a `u16` counts.
    pub fn from_model(model: &Model) -> Result<Self> {
        if model.joints.is_empty() || model.joints.len() > usize::from(u16::MAX) {
            let reason = format!("{} joints; 1 to 65535 can be used", model.joints.len());
            return Err(Error::argument("character", reason));
        }
        let mut names = std::collections::HashSet::new();
        let mut skeleton = Self::default();
        for (row, joint) in model.joints.iter().enumerate() {
            let refuse = |reason: &str| {
                Err(Error::Joint {
                    joint: joint.name.clone(),
                    reason: reason.into(),
                })
            };
            if !names.insert(joint.name.as_str()) {
                return refuse("the name is used twice");
            }
            if joint.parent.is_some_and(|p| p >= row) {
                return refuse("its parent does not precede it");
            }
            let bind = joint.inverse_bind.inverse();
            if !bind.is_finite() || !joint.inverse_bind.is_finite() {
                return refuse("its inverse bind matrix is not finite or has no inverse");
            }
            if let Some(parent) = joint.parent {
                skeleton.children[parent].push(row);
            }
            skeleton.children.push(Vec::new());
            skeleton.joints.push(Joint {
                name: joint.name.clone(),
                parent: joint.parent,
                bind,
                inverse_bind: joint.inverse_bind,
            });
        }
        Ok(skeleton)
    }

    /// Row of a joint by name.
    ///
    /// # Errors
    /// [`Error::Joint`] where there is none.
    pub fn find(&self, name: &str) -> Result<usize> {
        let found = self.joints.iter().position(|j| j.name == name);
        found.ok_or_else(|| Error::Joint {
            joint: name.into(),
            reason: "the character has no such joint".into(),
        })
    }

    /// Origin of a joint in rest space.
    pub fn origin(&self, joint: usize) -> Vec3 {
        self.joints[joint].bind.w_axis.truncate()
    }

    /// Bones of a joint in rest space: from its origin to each child's, in the children's order; none for a leaf.
    pub fn segments(&self, joint: usize) -> Vec<[Vec3; 2]> {
        self.children[joint]
            .iter()
            .map(|&child| [self.origin(joint), self.origin(child)])
            .collect()
    }
}

#[cfg(test)]
pub(crate) mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::asset;
    use glam::{Mat4, Quat};

    /// `root` at the origin, `elbow` at x = 1 turned by 30° about z, `hand` at x = 2, `tail` under the root.
    pub(crate) fn model() -> Model {
        let bend = Quat::from_rotation_z(0.5);
        let binds = [
            Mat4::IDENTITY,
            Mat4::from_rotation_translation(bend, Vec3::X),
            Mat4::from_rotation_translation(bend, 2.0 * Vec3::X),
            Mat4::from_translation(-Vec3::X),
        ];
        let parents = [None, Some(0), Some(1), Some(0)];
        let mut model = Model::default();
        for (k, name) in ["root", "elbow", "hand", "tail"].into_iter().enumerate() {
            let local = parents[k].map_or(binds[k], |p: usize| binds[p].inverse() * binds[k]);
            let (scale, rotation, translation) = local.to_scale_rotation_translation();
            model.nodes.push(asset::Node {
                name: name.into(),
                parent: parents[k],
                translation,
                rotation,
                scale,
                matrix: None,
            });
            model.joints.push(asset::Joint {
                name: name.into(),
                node: k,
                parent: parents[k],
                inverse_bind: binds[k].inverse(),
            });
        }
        model
    }

    pub(crate) fn skeleton() -> Skeleton {
        Skeleton::from_model(&model()).unwrap()
    }

    #[test]
    fn bones_run_from_joint_to_child() {
        let s = skeleton();
        assert_eq!(s.children[0], [1, 3]);
        assert_eq!(s.segments(0).len(), 2);
        assert!(s.segments(1)[0][1].distance(2.0 * Vec3::X) < 1e-6);
        assert!(s.segments(2).is_empty());
        assert_eq!(s.find("hand").unwrap(), 2);
        assert!(s.find("Hand").unwrap_err().to_string().contains("Hand"));
    }

    #[test]
    fn unusable_joints_are_refused_by_name() {
        let refused = |change: fn(&mut Model)| {
            let mut m = model();
            change(&mut m);
            Skeleton::from_model(&m).unwrap_err().to_string()
        };
        assert!(refused(|m| m.joints[2].inverse_bind = Mat4::ZERO).contains("hand"));
        assert!(refused(|m| m.joints[1].inverse_bind.x_axis.x = f32::NAN).contains("elbow"));
        assert!(refused(|m| m.joints[1].parent = Some(1)).contains("elbow"));
        assert!(refused(|m| m.joints[3].name = "hand".into()).contains("hand"));
        assert!(refused(|m| m.joints.clear()).contains("0 joints"));
    }
}
