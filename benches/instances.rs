//! Instances of a rig in one deformer, beside as many frames of a deformer with one and beside as many deformers: least and median
//! time, in turn, so that they can be compared on a machine that other work shares.
//!
//! `cargo bench --bench instances -- [ROUNDS [INSTANCES]] [FILE…]`; without files the project's mannequin.
#![allow(missing_docs)]

use std::{f32::consts::TAU, path::PathBuf, sync::Arc, time::Instant};

use dermis::{
    Error, asset,
    deformer::{Deformer, Device, Method, Settings, TrackedState},
    gpu::{Gpu, GpuOptions},
    rig::{self, Joint, Pose, Random, Rig},
};
use glam::Mat4;

const METHODS: [Method; 2] = [Method::Implicit, Method::Tracking];
const ROUNDS: usize = 12;
const INSTANCES: usize = 64;
/// Poses of a course, whose frames follow each other.
const POSES: usize = 128;
/// Most that a joint turns.
const DEGREES: f32 = 20.0;

fn main() -> dermis::Result<()> {
    let (rounds, instances, files) = arguments();
    let gpu = Gpu::new(&GpuOptions::default())?;
    let device = gpu.report();
    println!("{} ({}), {rounds} rounds", device.name, device.driver);
    for file in files {
        let model = asset::load(&file)?;
        let rig = Arc::new(Rig::prepare(&model, &rig::Options::default(), &|_| {})?);
        println!(
            "\n{}: {} welded vertices",
            file.display(),
            rig.mesh.positions.len()
        );
        for method in METHODS {
            measure(&gpu, &rig, method, (rounds, instances))?;
        }
    }
    Ok(())
}

/// Cargo adds `--bench`; options are not ours.
fn arguments() -> (usize, usize, Vec<PathBuf>) {
    let (mut numbers, mut files) = (Vec::new(), Vec::new());
    for argument in std::env::args().skip(1).filter(|a| !a.starts_with('-')) {
        match argument.parse::<usize>() {
            Ok(number) => numbers.push(number.max(1)),
            Err(_) => files.push(argument.into()),
        }
    }
    if files.is_empty() {
        files.push(PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("assets/mannequin.glb"));
    }
    let number = |row: usize, default| numbers.get(row).copied().unwrap_or(default);
    (number(0, ROUNDS), number(1, INSTANCES), files)
}

/// One period in which every joint but the roots swings about an axis of its own.
fn course(rig: &Rig) -> dermis::Result<Vec<Pose>> {
    let mut random = Random::new(1);
    let joints = &rig.skeleton.joints;
    let axes: Vec<_> = joints.iter().map(|_| random.direction()).collect();
    let pose = |k: usize| {
        let angle = DEGREES.to_radians() * (TAU * k as f32 / POSES as f32).sin();
        let turn = |(joint, axis): (&Joint, &glam::Vec3)| match joint.parent {
            Some(_) => Mat4::from_axis_angle(*axis, angle),
            None => Mat4::IDENTITY,
        };
        Pose::from_local(
            &rig.skeleton,
            &joints.iter().zip(&axes).map(turn).collect::<Vec<_>>(),
        )
    };
    (0..POSES).map(pose).collect()
}

fn measure(
    gpu: &Gpu,
    rig: &Arc<Rig>,
    method: Method,
    (rounds, instances): (usize, usize),
) -> dermis::Result<()> {
    let course = course(rig)?;
    let new = |instances: usize| {
        let settings = Settings {
            method,
            instances: instances as u32,
            ..Settings::default()
        };
        Deformer::new(&Device::Gpu(gpu.clone()), Arc::clone(rig), &settings)
    };
    let before = gpu.memory().total;
    let mut one = new(1)?;
    let of_one = gpu.memory().total - before;
    let mut all = new(instances)?;
    let of_all = gpu.memory().total - before - of_one;
    let own: Result<Vec<Deformer>, _> = (0..instances).map(|_| new(1)).collect();
    let mut own = own.or_else(|error| match error {
        // As many times the fields and operators are a lot.
        Error::Memory { .. } => {
            println!("\n{instances} deformers do not fit: {error}");
            Ok(Vec::new())
        }
        other => Err(other),
    })?;
    let mut states = vec![one.save()?; instances];
    let mut times: [Vec<[f64; 2]>; 3] = Default::default();
    for round in 0..=rounds {
        let pose = |i: usize| course[(round + i * POSES / instances) % POSES].clone();
        let poses: Vec<Pose> = (0..instances).map(pose).collect();
        let played = [
            together(&mut all, &poses)?,
            again_and_again(&mut one, &poses, &mut states)?,
            match own.is_empty() {
                true => [f64::NAN; 2],
                false => each_its_own(&mut own, &poses)?,
            },
        ];
        // The first round compiles shaders and comes from rest.
        if round > 0 {
            for (times, played) in times.iter_mut().zip(played) {
                times.push(played);
            }
        }
    }
    // The same work: the same bits.
    let last = all.instance(instances as u32 - 1)?.read()?;
    assert!(one.read()? == last);
    if let Some(own) = own.last_mut() {
        assert!(own.read()? == last);
    }
    print(method, instances, &times);
    let mega = |bytes: u64| bytes as f64 / f64::from(1 << 20);
    println!(
        "memory: {:.1} MiB at once, {:.1} MiB one",
        mega(of_all),
        mega(of_one)
    );
    Ok(())
}

/// All instances in one frame.
fn together(all: &mut Deformer, poses: &[Pose]) -> dermis::Result<[f64; 2]> {
    let clock = Clock::start();
    all.advance(poses)?;
    all.wait()?;
    Ok(clock.stop())
}

/// The same frames by one deformer of one instance, which finds its fields in the caches; where a frame follows from the one
/// before, from that of the same instance.
fn again_and_again(
    one: &mut Deformer,
    poses: &[Pose],
    states: &mut [Option<TrackedState>],
) -> dermis::Result<[f64; 2]> {
    let mut sum = [0.0; 2];
    for (pose, state) in poses.iter().zip(states) {
        if let Some(state) = state {
            one.restore(state)?;
        }
        let frame = together(one, std::slice::from_ref(pose))?;
        sum = [sum[0] + frame[0], sum[1] + frame[1]];
        *state = one.save()?;
    }
    Ok(sum)
}

/// The same frames by as many deformers of one instance, each with fields of its own.
fn each_its_own(own: &mut [Deformer], poses: &[Pose]) -> dermis::Result<[f64; 2]> {
    let clock = Clock::start();
    for (one, pose) in own.iter_mut().zip(poses) {
        one.advance(pose)?;
    }
    own.iter_mut().try_for_each(Deformer::wait)?;
    Ok(clock.stop())
}

/// Wall-clock, and what all threads of this process computed, which other work on the machine disturbs less.
struct Clock(Instant, f64);

impl Clock {
    fn start() -> Self {
        Self(Instant::now(), computed())
    }

    /// Milliseconds by both.
    fn stop(self) -> [f64; 2] {
        [self.0.elapsed().as_secs_f64() * 1e3, computed() - self.1]
    }
}

/// Milliseconds; 0 where the system does not tell.
fn computed() -> f64 {
    let threads = std::fs::read_dir("/proc/self/task")
        .into_iter()
        .flatten()
        .flatten();
    let text = threads.filter_map(|t| std::fs::read_to_string(t.path().join("schedstat")).ok());
    let ns = text.filter_map(|t| t.split(' ').next()?.parse::<f64>().ok());
    ns.sum::<f64>() * 1e-6
}

fn print(method: Method, instances: usize, times: &[Vec<[f64; 2]>; 3]) {
    let names = ["at once", "again and again", "deformers"];
    println!(
        "\n{:<30}{:>12}{:>12}{:>12}{:>12}",
        format!("{}, ms", method.name()),
        "wall least",
        "median",
        "cpu least",
        "median"
    );
    let column = |times: &[[f64; 2]], kind: usize| sorted(times.iter().map(|t| t[kind]));
    let figures = |times: &Vec<[f64; 2]>| {
        let [wall, cpu] = [0, 1].map(|kind| column(times, kind));
        [wall[0], wall[wall.len() / 2], cpu[0], cpu[cpu.len() / 2]]
    };
    let all = figures(&times[0]);
    let played = times.iter().filter(|t| t.iter().all(|t| t[0].is_finite()));
    for (name, times) in names.iter().zip(played) {
        let figures = figures(times);
        print!("{:<30}", format!("{instances} {name}"));
        figures.iter().for_each(|ms| print!("{ms:>12.1}"));
        print!("\n{:<30}", "  at once takes of it");
        let shares = all.iter().zip(figures).map(|(all, ms)| all / ms);
        shares.for_each(|share| print!("{share:>12.3}"));
        println!();
    }
}

fn sorted(values: impl Iterator<Item = f64>) -> Vec<f64> {
    let mut sorted: Vec<f64> = values.collect();
    sorted.sort_by(f64::total_cmp);
    sorted
}
