//! Poses from a file's animation clips (glTF 2.0, section 3.11 and appendix C).

use glam::{Mat4, Quat, Vec3, Vec4};

use super::{Pose, Skeleton};
use crate::{
    Error, Result,
    asset::{Channel, Interpolation, Model, Node, Property},
};

impl Pose {
    /// The pose of clip row `clip` at `seconds`; before the first and after the last key the clip holds.
    ///
    /// Model space is the space of the file's scene: T_j = G_node · inverse_bind.
    ///
    /// # Errors
    /// [`Error::Argument`] for a clip that the model has not or a time that is not finite; [`Error::Pose`] naming the node
    /// or joint where keys are unusable or a matrix is not finite and invertible.
    pub fn from_clip(
        model: &Model,
        skeleton: &Skeleton,
        clip: usize,
        seconds: f32,
    ) -> Result<Self> {
        let Some(clip) = model.clips.get(clip) else {
            let reason = format!("{clip} given, the file has {}", model.clips.len());
            return Err(Error::argument("clip", reason));
        };
        if !seconds.is_finite() {
            return Err(Error::argument("time", format!("{seconds} is not finite")));
        }
        let mut nodes = model.nodes.clone();
        for channel in &clip.channels {
            apply(&mut nodes, channel, seconds).ok_or_else(|| Error::Pose {
                element: format!("clip {:?}, node {}", clip.name, channel.node),
                reason: "its keys cannot be used".into(),
            })?;
        }
        let global = globals(&nodes);
        if model.joints.len() != skeleton.joints.len() {
            return Err(Error::argument("skeleton", "it belongs to another file"));
        }
        let joints = model.joints.iter().zip(&skeleton.joints);
        let pose = Self {
            matrices: joints
                .map(|(file, joint)| global[file.node] * joint.inverse_bind)
                .collect(),
        };
        pose.validate(skeleton)?;
        Ok(pose)
    }
}

/// Rest space → the space of the file's scene, by the first joint as the file poses it: where the file stands the rest
/// pose. The identity for a model without joints.
pub fn scene_from_rest(model: &Model) -> Mat4 {
    let first = model.joints.first();
    first.map_or(Mat4::IDENTITY, |joint| {
        globals(&model.nodes)[joint.node] * joint.inverse_bind
    })
}

/// Node space → scene space.
fn globals(nodes: &[Node]) -> Vec<Mat4> {
    let mut global: Vec<Mat4> = Vec::with_capacity(nodes.len());
    for node in nodes {
        let local = node.matrix.unwrap_or_else(|| {
            Mat4::from_scale_rotation_translation(node.scale, node.rotation, node.translation)
        });
        let parent = node.parent.map_or(Mat4::IDENTITY, |p| global[p]);
        global.push(parent * local);
    }
    global
}

/// Sets a node's property to the channel's value; a node given as a matrix is not animated.
fn apply(nodes: &mut [Node], channel: &Channel, seconds: f32) -> Option<()> {
    let node = nodes.get_mut(channel.node)?;
    if node.matrix.is_some() {
        return Some(());
    }
    let value = sample(channel, seconds)?;
    match channel.property {
        Property::Translation => node.translation = value.truncate(),
        Property::Scale => node.scale = value.truncate(),
        Property::Rotation => {
            node.rotation = Quat::from_vec4(value.try_normalize()?);
        }
    }
    Some(())
}

/// The value of a channel; a rotation is not yet normalised.
fn sample(channel: &Channel, seconds: f32) -> Option<Vec4> {
    let times = &channel.times;
    let last = times.len().checked_sub(1)?;
    let next = times.partition_point(|t| *t <= seconds);
    if next == 0 || next > last {
        return value(channel, next.min(last));
    }
    let k = next - 1;
    let span = times[next] - times[k];
    let s = ((seconds - times[k]) / span).clamp(0.0, 1.0);
    let (a, b) = (value(channel, k)?, value(channel, next)?);
    match channel.interpolation {
        Interpolation::Step => Some(a),
        Interpolation::Linear if channel.property == Property::Rotation => {
            let (a, b) = (a.try_normalize()?, b.try_normalize()?);
            Some(Quat::from_vec4(a).slerp(Quat::from_vec4(b), s).into())
        }
        Interpolation::Linear => Some(a.lerp(b, s)),
        Interpolation::CubicSpline => {
            let leave = element(channel, 3 * k + 2)? * span;
            let enter = element(channel, 3 * next)? * span;
            let (s2, s3) = (s * s, s * s * s);
            Some(
                a * (2.0 * s3 - 3.0 * s2 + 1.0)
                    + leave * (s3 - 2.0 * s2 + s)
                    + b * (3.0 * s2 - 2.0 * s3)
                    + enter * (s3 - s2),
            )
        }
    }
}

/// The value at a key.
fn value(channel: &Channel, key: usize) -> Option<Vec4> {
    match channel.interpolation {
        Interpolation::CubicSpline => element(channel, 3 * key + 1),
        _ => element(channel, key),
    }
}

fn element(channel: &Channel, row: usize) -> Option<Vec4> {
    let width = if channel.property == Property::Rotation {
        4
    } else {
        3
    };
    let v = channel.values.get(row * width..(row + 1) * width)?;
    Some(match v {
        [x, y, z, w] => Vec4::new(*x, *y, *z, *w),
        _ => Vec3::from_slice(v).extend(0.0),
    })
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::{asset::Clip, rig::skeleton::tests::model};

    fn channel(interpolation: Interpolation, property: Property, values: &[f32]) -> Channel {
        Channel {
            node: 1,
            property,
            interpolation,
            times: vec![1.0, 3.0],
            values: values.to_vec(),
        }
    }

    #[test]
    fn rotations_take_the_shortest_arc() {
        let a = Quat::from_rotation_z(0.2);
        let b = -Quat::from_rotation_z(1.2);
        let values = [a.to_array(), b.to_array()].concat();
        let c = channel(Interpolation::Linear, Property::Rotation, &values);
        let half = Quat::from_vec4(sample(&c, 2.0).unwrap());
        assert!(half.angle_between(Quat::from_rotation_z(0.7)) < 1e-3);
        assert_eq!(sample(&c, -1.0).unwrap(), a.into());
        assert_eq!(sample(&c, 9.0).unwrap(), b.into());
    }

    #[test]
    fn steps_hold_and_lines_run_straight() {
        let values = [0.0, 0.0, 0.0, 2.0, 4.0, 6.0];
        let step = channel(Interpolation::Step, Property::Translation, &values);
        assert_eq!(sample(&step, 2.9).unwrap(), Vec4::ZERO);
        assert_eq!(sample(&step, 3.0).unwrap().y, 4.0);
        let line = channel(Interpolation::Linear, Property::Scale, &values);
        assert_eq!(sample(&line, 1.5).unwrap(), Vec4::new(0.5, 1.0, 1.5, 0.0));
    }

    #[test]
    fn a_cubic_spline_reproduces_a_cubic() {
        // x(t) = t³ on t in [1, 3]; tangents are dx/dt.
        let key = |t: f32| [[3.0 * t * t; 3], [t * t * t; 3], [3.0 * t * t; 3]].concat();
        let values = [key(1.0), key(3.0)].concat();
        let c = channel(Interpolation::CubicSpline, Property::Translation, &values);
        for t in [1.0f32, 1.3, 2.0, 2.9, 3.0] {
            assert!((sample(&c, t).unwrap().x - t * t * t).abs() < 1e-4, "{t}");
        }
    }

    #[test]
    fn the_scene_stands_a_character_up_that_is_bound_lying_down() {
        let mut model = model();
        assert!(scene_from_rest(&model).abs_diff_eq(Mat4::IDENTITY, 1e-6));
        let up = Mat4::from_rotation_x(-1.5);
        model.joints[0].inverse_bind = up;
        assert!(scene_from_rest(&model).abs_diff_eq(up, 1e-6));
        assert_eq!(scene_from_rest(&Model::default()), Mat4::IDENTITY);
    }

    #[test]
    fn an_animated_node_moves_its_joint() {
        let mut model = model();
        let skeleton = Skeleton::from_model(&model).unwrap();
        let turn = Quat::from_rotation_y(0.5).to_array();
        model.clips.push(Clip {
            name: "bend".into(),
            seconds: 3.0,
            channels: vec![channel(
                Interpolation::Linear,
                Property::Rotation,
                &[turn, turn].concat(),
            )],
        });
        let pose = Pose::from_clip(&model, &skeleton, 0, 2.0).unwrap();
        assert_eq!(pose.matrices[0], Mat4::IDENTITY);
        let elbow = Mat4::from_translation(Vec3::X) * Mat4::from_rotation_y(0.5);
        let wanted = elbow * model.joints[1].inverse_bind;
        assert!(pose.matrices[1].abs_diff_eq(wanted, 1e-6));
        assert!(Pose::from_clip(&model, &skeleton, 1, 0.0).is_err());
        assert!(Pose::from_clip(&model, &skeleton, 0, f32::NAN).is_err());
        model.clips[0].channels[0].values.truncate(4);
        let error = Pose::from_clip(&model, &skeleton, 0, 2.0).unwrap_err();
        assert!(error.to_string().contains("bend"));
    }
}
