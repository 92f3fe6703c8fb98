//! `dermis bench`: what a frame costs, pass by pass.

use std::{f32::consts::TAU, path::PathBuf};

use dermis::{
    Error, Result,
    deformer::Device,
    gpu::{Gpu, Profile},
    rig::{Joint, Pose, Random, Skeleton},
};
use glam::{Mat4, Vec3};

use crate::{
    bench_report::Report,
    bench_run::{Length, Run},
    console::{self, Console},
    options::{DeviceOptions, MethodName, PoseOptions, ReportOptions, RigOptions},
    parse,
    poses::{Fallback, Frames},
    session::{Character, Session, check_validation, open_device},
};

/// Poses where the user names neither poses nor a number of frames.
const POSES: u32 = 60;

/// Measure what a frame costs: passes, memory, and the device's own ceiling in the same run.
#[derive(clap::Args)]
#[command(after_help = "\
Plays the chosen poses in turn: by default the file's first clip, or random poses where it has none. Every frame is
waited for, so that times do not overlap. Timestamps cost time, so that a frame times a few passes, in turn, and the
ceiling is measured between the turns. Times are the least, the median and the 95th percentile over the frames;
compare the least ones between runs on a shared machine. What timing adds to a pass is measured, too, and taken off;
the frame's own times are of frames that time no pass, and shares are of means. With --instances all is
told of all instances together, but for the last row, which is the share of one.

Examples:
  dermis bench human-male.glb                        all joints move, as in the clip
  dermis bench human-male.glb --random 60            random poses, up to 45° a joint
  dermis bench hand.glb --one-joint index2           one joint moves
  dermis bench human-male.glb --method tracking --step 0.05
  dermis bench mannequin.glb --instances 64          64 at once: fields once, one set of dispatches
  dermis bench arm.glb --json - | jq '.frame.gpu_ms'
  dermis bench arm.glb --compare-profiling           what timestamps cost")]
pub(crate) struct Args {
    /// glTF or GLB file.
    file: PathBuf,
    /// Frames to measure, rounded up so that every pass is timed equally often; by default at least 60, and nine of every
    /// pass.
    #[arg(long, short = 'n', value_name = "N", value_parser = clap::value_parser!(u32).range(1..=100_000))]
    count: Option<u32>,
    /// Frames to play before, unmeasured, at least one: shaders are compiled on first use.
    #[arg(long, value_name = "N", default_value_t = 5)]
    warm_up: u32,
    /// Swing this joint alone by up to 45° (or --degrees) and leave the others at rest.
    #[arg(long, value_name = "NAME", group = "source")]
    one_joint: Option<String>,
    /// Swing all joints at once by up to 20° (or --degrees), each about an axis of its own, by this many radians a frame.
    #[arg(long, value_name = "X", group = "source", value_parser = parse::positive)]
    step: Option<f32>,
    /// Instances of the character, deformed together; each plays the poses from a place of its own, evenly apart.
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=65_535))]
    instances: u32,
    /// Also play each frame without timestamps, in turn, and say what they cost.
    #[arg(long)]
    compare_profiling: bool,
    /// How to deform.
    #[arg(long, value_enum, default_value = "implicit")]
    method: MethodName,
    #[command(flatten)]
    poses: PoseOptions,
    #[command(flatten)]
    rig: RigOptions,
    #[command(flatten)]
    device: DeviceOptions,
    #[command(flatten)]
    report: ReportOptions,
}

pub(crate) fn run(args: &Args) -> Result<()> {
    let console = Console::new(&args.report);
    let method = args.method.method();
    if args.compare_profiling && args.device.device == crate::parse::DeviceChoice::Cpu {
        let reason = "the cpu device has no timestamps to compare";
        return Err(Error::argument("--compare-profiling", reason));
    }
    let character = Character::load(&args.file)?;
    let (source, poses) = choose_poses(args, &character, &console)?;
    let profile = Profile::Sampled;
    let session = Session::open(character, &args.rig, &args.device, profile, &console)?;
    let length = Length {
        warm_up: args.warm_up as usize,
        frames: args.count.map(|count| count as usize),
    };
    let ceiling = ceiling_device(args, &session.device)?;
    let deformer = session.deformer_of(method, args.instances)?;
    let run = Run::new(&session, deformer, ceiling.as_ref(), args.compare_profiling)?;
    let measured = run.measure(&poses, length)?;
    if let Some(gpu) = ceiling {
        check_validation(&Device::Gpu(gpu))?;
    }
    session.finish()?;
    let report = Report::new(&session, args.method.name(), &measured);
    console.text(report.text(&source).trim_end())?;
    console::json(&args.report, &report)
}

fn choose_poses(
    args: &Args,
    character: &Character,
    console: &Console,
) -> Result<(String, Vec<Pose>)> {
    let degrees = args.poses.degrees.unwrap_or(45.0);
    let count = args.count.unwrap_or(POSES);
    if let Some(name) = &args.one_joint {
        let poses = swing(&character.skeleton, name, degrees, count)?;
        return Ok((format!("joint {name} alone ±{degrees}°"), poses));
    }
    if let Some(step) = args.step {
        let degrees = args.poses.degrees.unwrap_or(20.0);
        let poses = sway(&character.skeleton, step, degrees, args.poses.seed)?;
        let source = format!("all joints ±{degrees}°, {step} rad a frame");
        return Ok((source, poses));
    }
    let fallback = Fallback::Random(count);
    let frames = Frames::choose(&args.poses, character, fallback, degrees, console)?;
    let poses = frames.frames.into_iter().map(|f| f.pose).collect();
    Ok((frames.source, poses))
}

/// One period of a swing of one joint about a skew axis of its own; what hangs on it comes along.
fn swing(skeleton: &Skeleton, name: &str, degrees: f32, count: u32) -> Result<Vec<Pose>> {
    let row = skeleton.find(name)?;
    let axis = Vec3::ONE.normalize();
    let pose = |i: u32| {
        let angle = degrees.to_radians() * (TAU * i as f32 / count as f32).sin();
        let mut local = vec![Mat4::IDENTITY; skeleton.joints.len()];
        local[row] = Mat4::from_axis_angle(axis, angle);
        Pose::from_local(skeleton, &local)
    };
    (0..count).map(pose).collect()
}

/// One period in which all joints but the roots swing between ±`degrees` at an even speed, each about a random axis.
fn sway(skeleton: &Skeleton, step: f32, degrees: f32, seed: u64) -> Result<Vec<Pose>> {
    let quarter = (degrees.to_radians() / step).ceil().max(1.0) as i32;
    let mut random = Random::new(seed);
    let axes: Vec<Vec3> = skeleton.joints.iter().map(|_| random.direction()).collect();
    let pose = |k: i32| {
        let height = if k < quarter {
            k
        } else if k < 3 * quarter {
            2 * quarter - k
        } else {
            k - 4 * quarter
        };
        let angle = degrees.to_radians() * height as f32 / quarter as f32;
        let joints = skeleton.joints.iter().zip(&axes);
        let turn = |(joint, axis): (&Joint, &Vec3)| match joint.parent {
            Some(_) => Mat4::from_axis_angle(*axis, angle),
            None => Mat4::IDENTITY,
        };
        Pose::from_local(skeleton, &joints.map(turn).collect::<Vec<_>>())
    };
    (0..4 * quarter).map(pose).collect()
}

/// A device of its own for the ceiling: the memory budget is for the character.
fn ceiling_device(args: &Args, device: &Device) -> Result<Option<Gpu>> {
    if matches!(device, Device::Cpu) {
        return Ok(None);
    }
    let options = DeviceOptions {
        budget: None,
        ..args.device.clone()
    };
    let quiet = Console::new(&ReportOptions {
        json: None,
        quiet: true,
    });
    Ok(match open_device(&options, Profile::Off, &quiet)? {
        Device::Gpu(gpu) => Some(gpu),
        Device::Cpu => None,
    })
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn chain() -> Skeleton {
        let joint = |name: &str, parent: Option<usize>, x: f32| {
            let bind = Mat4::from_translation(Vec3::X * x);
            Joint {
                name: name.into(),
                parent,
                bind,
                inverse_bind: bind.inverse(),
            }
        };
        Skeleton {
            joints: vec![
                joint("root", None, 0.0),
                joint("arm", Some(0), 1.0),
                joint("leg", Some(0), 5.0),
                joint("hand", Some(1), 2.0),
            ],
            children: vec![vec![1, 2], vec![3], vec![], vec![]],
        }
    }

    #[test]
    fn a_swing_moves_the_joint_and_what_hangs_on_it() {
        let poses = swing(&chain(), "arm", 40.0, 8).unwrap();
        let quarter = &poses[2];
        assert_eq!(quarter.matrices[0], Mat4::IDENTITY);
        assert_eq!(quarter.matrices[2], Mat4::IDENTITY);
        assert_eq!(quarter.matrices[1], quarter.matrices[3]);
        let (_, rotation, _) = quarter.matrices[1].to_scale_rotation_translation();
        let (_, angle) = rotation.to_axis_angle();
        assert!((angle.to_degrees() - 40.0).abs() < 1e-3);
        // The joint itself stays where it is.
        let origin = quarter.matrices[1].transform_point3(Vec3::X);
        assert!(origin.distance(Vec3::X) < 1e-6);
    }

    #[test]
    fn all_joints_sway_by_even_steps() {
        let poses = sway(&chain(), 0.1, 20.0, 1).unwrap();
        assert_eq!(poses.len(), 16);
        let turned = |a: &Pose, b: &Pose| {
            let change = a.matrices[1].inverse() * b.matrices[1];
            change.to_scale_rotation_translation().1.to_axis_angle().1
        };
        let next = poses.iter().cycle().skip(1);
        for (a, b) in poses.iter().zip(next) {
            assert!((turned(a, b) - 20f32.to_radians() / 4.0).abs() < 1e-3);
        }
        assert_eq!(poses[0].matrices, Pose::rest(&chain()).matrices);
    }

    #[test]
    fn an_unknown_joint_is_named() {
        let error = swing(&chain(), "tail", 40.0, 8).unwrap_err().to_string();
        assert!(error.contains("tail"), "{error}");
    }
}
