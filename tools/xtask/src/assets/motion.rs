//! Joints that turn, and clips of their turns.

use dermis::asset::{Channel, Clip, Interpolation, Joint, Model, Node, Property};
use glam::{DQuat, DVec3, Mat4, Quat, Vec3};

/// A joint of a character under construction; its frame at rest is parallel to the model's.
#[derive(Clone, Debug)]
pub(crate) struct Bone {
    /// Name.
    pub(crate) name: String,
    /// Row of the parent.
    pub(crate) parent: Option<usize>,
    /// Position at rest, in model space.
    pub(crate) at: DVec3,
}

/// Joints by name, parents before children.
#[derive(Clone, Debug, Default)]
pub(crate) struct Bones(pub(crate) Vec<Bone>);

impl Bones {
    /// Adds a joint and returns its row.
    pub(crate) fn add(
        &mut self,
        name: impl Into<String>,
        parent: Option<usize>,
        at: DVec3,
    ) -> usize {
        self.0.push(Bone {
            name: name.into(),
            parent,
            at,
        });
        self.0.len() - 1
    }

    /// Row of a joint; the first where there is none of that name.
    pub(crate) fn row(&self, name: &str) -> usize {
        debug_assert!(self.0.iter().any(|b| b.name == name), "{name}");
        self.0.iter().position(|b| b.name == name).unwrap_or(0)
    }

    /// Where a point that is fixed to a joint goes in a pose.
    pub(crate) fn posed(&self, joint: usize, point: DVec3, pose: &Pose) -> DVec3 {
        let bone = &self.0[joint];
        let local = pose.turns[joint] * (point - bone.at);
        match bone.parent {
            Some(parent) => self.posed(parent, bone.at + local, pose),
            None => bone.at + local + pose.shift,
        }
    }

    /// Puts nodes and joints into a model.
    pub(crate) fn put(&self, model: &mut Model) {
        for (node, bone) in self.0.iter().enumerate() {
            let origin = bone.parent.map_or(DVec3::ZERO, |p| self.0[p].at);
            model.nodes.push(Node {
                name: bone.name.clone(),
                parent: bone.parent,
                translation: (bone.at - origin).as_vec3(),
                rotation: Quat::IDENTITY,
                scale: Vec3::ONE,
                matrix: None,
            });
            model.joints.push(Joint {
                name: bone.name.clone(),
                node,
                parent: bone.parent,
                inverse_bind: Mat4::from_translation(-bone.at.as_vec3()),
            });
        }
    }
}

/// A turn for each joint, in its parent's frame, and a shift of the root.
#[derive(Clone, Debug)]
pub(crate) struct Pose {
    /// One rotation a joint.
    pub(crate) turns: Vec<DQuat>,
    /// Of the root, in model space.
    pub(crate) shift: DVec3,
}

impl Pose {
    /// The rest pose.
    pub(crate) fn rest(bones: &Bones) -> Self {
        Self {
            turns: vec![DQuat::IDENTITY; bones.0.len()],
            shift: DVec3::ZERO,
        }
    }

    /// Turns a joint further, in its own turned frame.
    pub(crate) fn turn(&mut self, joint: usize, axis: DVec3, degrees: f64) {
        self.turns[joint] = (self.turns[joint] * turn(axis, degrees)).normalize();
    }

    /// Between two poses; `t` from 0 to 1.
    pub(crate) fn between(&self, other: &Self, t: f64) -> Self {
        let turns = self.turns.iter().zip(&other.turns).map(|(a, b)| {
            let b = if a.dot(*b) < 0.0 { -*b } else { *b };
            // Normalised linear interpolation: exact enough between keys that are close.
            (*a * (1.0 - t) + b * t).normalize()
        });
        Self {
            turns: turns.collect(),
            shift: self.shift.lerp(other.shift, t),
        }
    }
}

/// Rotation about a unit axis.
pub(crate) fn turn(axis: DVec3, degrees: f64) -> DQuat {
    let [sin, cos] = sin_cos(degrees / 2.0);
    let v = axis * sin;
    DQuat::from_xyzw(v.x, v.y, v.z, cos)
}

/// Sine and cosine of an angle in degrees, the same bits everywhere.
pub(crate) fn sin_cos(degrees: f64) -> [f64; 2] {
    let quarter = (degrees / 90.0).round();
    let x = (degrees - 90.0 * quarter) * (std::f64::consts::PI / 180.0);
    // Taylor series for |x| <= pi/4; the first term left out is below 1e-18.
    let (mut sin, mut cos, mut term) = (0.0, 0.0, 1.0);
    for n in 0..18 {
        let sign = if n & 2 == 0 { term } else { -term };
        if n & 1 == 0 {
            cos += sign
        } else {
            sin += sign
        }
        term *= x / f64::from(n + 1);
    }
    match quarter.rem_euclid(4.0) as u8 {
        0 => [sin, cos],
        1 => [cos, -sin],
        2 => [-sin, -cos],
        _ => [-cos, sin],
    }
}

/// From 0 to 1 with no speed at either end.
pub(crate) fn ease(t: f64) -> f64 {
    t * t * (3.0 - 2.0 * t)
}

/// A clip of poses at equal steps of time; joints that never turn have no channel.
pub(crate) fn clip(name: &str, seconds: f64, poses: &[Pose]) -> Clip {
    let step = seconds / (poses.len() - 1) as f64;
    let times: Vec<f32> = (0..poses.len()).map(|i| (i as f64 * step) as f32).collect();
    let mut channels = Vec::new();
    let mut channel = |node, property, values: Vec<f32>| {
        let times = times.clone();
        channels.push(Channel {
            node,
            property,
            interpolation: Interpolation::Linear,
            times,
            values,
        });
    };
    for joint in 0..poses[0].turns.len() {
        let moves = poses.iter().any(|p| p.turns[joint] != DQuat::IDENTITY);
        if moves {
            let turns = poses
                .iter()
                .flat_map(|p| p.turns[joint].as_quat().to_array());
            channel(joint, Property::Rotation, turns.collect());
        }
    }
    Clip {
        name: name.into(),
        seconds: seconds as f32,
        channels,
    }
}

/// Adds the root's way to a clip.
pub(crate) fn add_way(clip: &mut Clip, root: DVec3, poses: &[Pose]) {
    let times = clip.channels[0].times.clone();
    let values = poses
        .iter()
        .flat_map(|p| (root + p.shift).as_vec3().to_array())
        .collect();
    let (property, interpolation) = (Property::Translation, Interpolation::Linear);
    clip.channels.insert(
        0,
        Channel {
            node: 0,
            property,
            interpolation,
            times,
            values,
        },
    );
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sine_and_cosine_agree_with_the_library() {
        for degrees in -720..=720 {
            let [sin, cos] = sin_cos(f64::from(degrees) * 0.7);
            let angle = (f64::from(degrees) * 0.7).to_radians();
            assert!((sin - angle.sin()).abs() < 1e-14 && (cos - angle.cos()).abs() < 1e-14);
        }
    }

    #[test]
    fn a_point_follows_its_chain() {
        let mut bones = Bones::default();
        let root = bones.add("root", None, DVec3::ZERO);
        let child = bones.add("child", Some(root), DVec3::X);
        let mut pose = Pose::rest(&bones);
        pose.turn(root, DVec3::Z, 90.0);
        pose.turn(child, DVec3::Z, 90.0);
        let tip = bones.posed(child, DVec3::X * 2.0, &pose);
        assert!(tip.distance(DVec3::new(-1.0, 1.0, 0.0)) < 1e-12, "{tip}");
    }
}
