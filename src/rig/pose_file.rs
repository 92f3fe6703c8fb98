//! Poses from a file of the user: joint name → rotation, translation and scale in the joint's own frame.

use std::path::{Path, PathBuf};

use glam::{Mat4, Quat, Vec3};
use serde_json::Value;

use super::{Pose, Skeleton};
use crate::{Error, Result};

/// Transform of a joint after its bind transform, in its own frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JointPose {
    /// Translation in joint units.
    pub translation: Vec3,
    /// Unit rotation.
    pub rotation: Quat,
    /// Scale along the joint's axes.
    pub scale: Vec3,
}

impl Default for JointPose {
    fn default() -> Self {
        Self {
            translation: Vec3::ZERO,
            rotation: Quat::IDENTITY,
            scale: Vec3::ONE,
        }
    }
}

impl From<JointPose> for Mat4 {
    fn from(p: JointPose) -> Self {
        Mat4::from_scale_rotation_translation(p.scale, p.rotation, p.translation)
    }
}

/// A sequence of poses by joint name; joints that a frame leaves out stay at rest.
#[derive(Clone, Debug)]
pub struct PoseFile {
    /// The file.
    pub path: PathBuf,
    /// Joint name and transform, a list a frame.
    pub frames: Vec<Vec<(String, JointPose)>>,
}

impl PoseFile {
    /// Reads JSON: an object (one pose) or a list of objects (a sequence) of joint name → quaternion `[x, y, z, w]` or
    /// `{"axis": [x, y, z], "degrees": d}` or `{"rotation": [x, y, z, w]}`, the last two with optional
    /// `"translation": [x, y, z]` and `"scale": s` or `[x, y, z]`.
    ///
    /// # Errors
    /// [`Error::File`] where it cannot be read; [`Error::Asset`] naming frame and joint for anything else than the above,
    /// numbers that are not finite, a zero axis or quaternion, a zero scale, an empty list.
    pub fn read(path: &Path) -> Result<Self> {
        let bytes = std::fs::read(path).map_err(|e| Error::file(path, e))?;
        Self::parse(path, &bytes)
    }

    fn parse(path: &Path, bytes: &[u8]) -> Result<Self> {
        let json: Value =
            serde_json::from_slice(bytes).map_err(|e| Error::asset(path, "JSON", e.to_string()))?;
        let list = match json {
            Value::Array(list) => list,
            one => vec![one],
        };
        if list.is_empty() {
            return Err(Error::asset(path, "list of poses", "it is empty"));
        }
        let mut frames = Vec::with_capacity(list.len());
        for (row, frame) in list.iter().enumerate() {
            let Some(joints) = frame.as_object() else {
                let reason = "an object of joint name to rotation is wanted";
                return Err(Error::asset(path, format!("frame {row}"), reason));
            };
            let mut parsed = Vec::with_capacity(joints.len());
            for (name, value) in joints {
                let pose = joint_pose(value).map_err(|reason| {
                    Error::asset(path, format!("frame {row}, joint {name:?}"), reason)
                })?;
                parsed.push((name.clone(), pose));
            }
            frames.push(parsed);
        }
        Ok(Self {
            path: path.into(),
            frames,
        })
    }
}

impl Pose {
    /// Pose of one frame of a pose file.
    ///
    /// # Errors
    /// [`Error::Argument`] where the file has no such frame; [`Error::Asset`] naming file, frame and joint where the
    /// skeleton has no such joint; [`Error::Pose`] where a matrix is not finite and invertible.
    pub fn from_file_frame(file: &PoseFile, skeleton: &Skeleton, frame: usize) -> Result<Self> {
        let Some(joints) = file.frames.get(frame) else {
            let reason = format!("{frame} given, the pose file has {}", file.frames.len());
            return Err(Error::argument("frame", reason));
        };
        let mut local = vec![Mat4::IDENTITY; skeleton.joints.len()];
        for (name, pose) in joints {
            let Some(j) = skeleton.joints.iter().position(|j| j.name == *name) else {
                let element = format!("frame {frame}, joint {name:?}");
                let reason = "the character has no such joint";
                return Err(Error::asset(&file.path, element, reason));
            };
            local[j] = (*pose).into();
        }
        Self::from_local(skeleton, &local)
    }
}

fn joint_pose(value: &Value) -> Result<JointPose, String> {
    let mut pose = JointPose::default();
    if value.is_array() {
        pose.rotation = quaternion(value)?;
        return Ok(pose);
    }
    let map = value
        .as_object()
        .ok_or("a quaternion [x, y, z, w] or an object is wanted")?;
    for (key, value) in map {
        match key.as_str() {
            "axis" | "degrees" => {}
            "rotation" => pose.rotation = quaternion(value)?,
            "translation" => pose.translation = numbers::<3>(value, key)?.into(),
            "scale" => {
                pose.scale = match value {
                    Value::Number(_) => Vec3::splat(number(value, key)?),
                    _ => numbers::<3>(value, key)?.into(),
                };
            }
            _ => return Err(format!("unknown key {key:?}")),
        }
    }
    if pose.scale.abs().min_element() == 0.0 {
        return Err("scale 0 has no inverse".into());
    }
    match (map.get("axis"), map.get("degrees")) {
        (None, None) => {}
        (Some(_), Some(_)) if map.contains_key("rotation") => {
            return Err("both a rotation and an axis".into());
        }
        (Some(axis), Some(degrees)) => {
            let axis: Vec3 = numbers::<3>(axis, "axis")?.into();
            let axis = axis.try_normalize().ok_or("the axis has no length")?;
            let angle = number(degrees, "degrees")?.to_radians();
            pose.rotation = Quat::from_axis_angle(axis, angle);
        }
        _ => return Err("axis and degrees go together".into()),
    }
    Ok(pose)
}

fn quaternion(value: &Value) -> Result<Quat, String> {
    let q = glam::Vec4::from(numbers::<4>(value, "quaternion")?);
    q.try_normalize()
        .map(Quat::from_vec4)
        .ok_or_else(|| "the quaternion has no length".into())
}

fn numbers<const N: usize>(value: &Value, what: &str) -> Result<[f32; N], String> {
    let wrong = || format!("{what} wants {N} numbers");
    let list = value
        .as_array()
        .filter(|l| l.len() == N)
        .ok_or_else(wrong)?;
    let mut numbers = [0.0; N];
    for (out, value) in numbers.iter_mut().zip(list) {
        *out = number(value, what)?;
    }
    Ok(numbers)
}

fn number(value: &Value, what: &str) -> Result<f32, String> {
    value
        .as_f64()
        .map(|x| x as f32)
        .filter(|x| x.is_finite())
        .ok_or_else(|| format!("{what}: {value} is no finite number"))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::rig::skeleton::tests::skeleton;

    fn parse(text: &str) -> Result<PoseFile> {
        PoseFile::parse(Path::new("bend.json"), text.as_bytes())
    }

    #[test]
    fn axis_quaternion_and_sequence_agree() {
        let file = parse(
            r#"[{"elbow": {"axis": [0, 0, 2], "degrees": 90}},
                {"elbow": [0, 0, 0.5, 0.5]},
                {"elbow": {"rotation": [0, 0, 1, 1], "translation": [0, 1, 0], "scale": 2}, "tail": {"scale": [1, 2, 3]}}]"#,
        )
        .unwrap();
        let s = skeleton();
        let poses: Vec<Pose> = (0..3)
            .map(|k| Pose::from_file_frame(&file, &s, k).unwrap())
            .collect();
        assert!(poses[0].matrices[2].abs_diff_eq(poses[1].matrices[2], 1e-6));
        let hand = poses[0].matrices[2].transform_point3(2.0 * Vec3::X);
        assert!(hand.distance(Vec3::new(1.0, 1.0, 0.0)) < 1e-6);
        let wider = poses[2].matrices[1].determinant();
        assert!((wider - 8.0).abs() < 1e-4);
        assert!((poses[2].matrices[3].determinant() - 6.0).abs() < 1e-4);
        assert!(Pose::from_file_frame(&file, &s, 3).is_err());
    }

    #[test]
    fn nonsense_is_refused_naming_file_frame_and_joint() {
        for (text, part) in [
            (
                r#"[{}, {"elbow": [0, 0, 0, 0]}]"#,
                "frame 1, joint \"elbow\"",
            ),
            (r#"{"elbow": [0, 0, 1]}"#, "4 numbers"),
            (r#"{"elbow": [0, 0, 1, 1e99]}"#, "finite"),
            (r#"{"elbow": [0, 0, null, 1]}"#, "finite"),
            (
                r#"{"elbow": {"axis": [0, 0, 0], "degrees": 3}}"#,
                "no length",
            ),
            (r#"{"elbow": {"axis": [0, 0, 1]}}"#, "together"),
            (r#"{"elbow": {"angle": 3}}"#, "angle"),
            (r#"{"elbow": {"scale": [1, 0, 1]}}"#, "scale 0"),
            (r#"{"elbow": 3}"#, "quaternion"),
            ("[]", "empty"),
            ("[3]", "frame 0"),
            ("{", "JSON"),
        ] {
            let error = parse(text).unwrap_err().to_string();
            assert!(error.starts_with("bend.json"), "{error}");
            assert!(error.contains(part), "{error} has no {part}");
        }
    }

    #[test]
    fn an_unknown_joint_is_refused_by_name() {
        let file = parse(r#"{"knee": [0, 0, 0, 1]}"#).unwrap();
        let error = Pose::from_file_frame(&file, &skeleton(), 0).unwrap_err();
        assert!(error.to_string().contains("frame 0, joint \"knee\""));
    }
}
