//! Instances of a rig in one deformer beside as many frames of a deformer with one: least and median time, in turn, so that they
//! can be compared on a machine that other work shares.
//!
//! `cargo bench --bench instances -- [ROUNDS [INSTANCES]] [FILE…]`; without files the project's mannequin.
#![allow(missing_docs)]

use std::{error::Error, f32::consts::TAU, path::PathBuf, sync::Arc, time::Instant};

use dermis::{
    asset,
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

fn main() -> Result<(), Box<dyn Error>> {
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
    let before = gpu.memory();
    let mut one = new(1)?;
    let own = gpu.memory().total - before.total;
    let mut all = new(instances)?;
    let memory = gpu.memory().total - before.total - own;
    let mut states = vec![one.save()?; instances];
    let mut times = [[Vec::new(), Vec::new()], [Vec::new(), Vec::new()]];
    for round in 0..=rounds {
        let pose = |i: usize| course[(round + i * POSES / instances) % POSES].clone();
        let poses: Vec<Pose> = (0..instances).map(pose).collect();
        let clock = Clock::start();
        all.advance(&poses)?;
        all.wait()?;
        let together = clock.stop();
        let apart = one_by_one(&mut one, &poses, &mut states)?;
        // The first round compiles shaders and comes from rest.
        if round > 0 {
            for (kind, times) in times.iter_mut().enumerate() {
                times[0].push(together[kind]);
                times[1].push(apart[kind]);
            }
        }
    }
    // The same work: the same bits.
    let last = all.instance(instances as u32 - 1)?.read()?;
    assert!(one.read()? == last);
    for (kind, times) in ["wall", "cpu"].iter().zip(&times) {
        print(&format!("{} {kind}", method.name()), instances, times);
    }
    let mega = |bytes: u64| bytes as f64 / f64::from(1 << 20);
    println!(
        "{:<34}{:>10.1} MiB, one {:.1}",
        "  memory",
        mega(memory),
        mega(own)
    );
    Ok(())
}

/// The same frames by a deformer of one instance; where a frame follows from the one before, from that of the same instance.
fn one_by_one(
    one: &mut Deformer,
    poses: &[Pose],
    states: &mut [Option<TrackedState>],
) -> dermis::Result<[f64; 2]> {
    let mut sum = [0.0; 2];
    for (pose, state) in poses.iter().zip(states) {
        if let Some(state) = state {
            one.restore(state)?;
        }
        let clock = Clock::start();
        one.advance(pose)?;
        one.wait()?;
        let frame = clock.stop();
        sum = [sum[0] + frame[0], sum[1] + frame[1]];
        *state = one.save()?;
    }
    Ok(sum)
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

fn print(name: &str, instances: usize, [all, one]: &[Vec<f64>; 2]) {
    let pairs = all.iter().zip(one).map(|(a, b)| a / b);
    let (least, median) = (|x: &[f64]| sorted(x)[0], |x: &[f64]| sorted(x)[x.len() / 2]);
    let of_pairs = median(&pairs.collect::<Vec<_>>());
    let title = format!("{name} {instances} at once");
    println!(
        "{title:<34}{:>10.2} ms least {:>10.2} median",
        least(all),
        median(all)
    );
    let title = format!("{name} {instances} x one");
    println!(
        "{title:<34}{:>10.2} ms least {:>10.2} median",
        least(one),
        median(one)
    );
    println!(
        "{:<34}{:>10.3}          {:>10.3}, of pairs {of_pairs:.3}",
        "  ratio",
        least(all) / least(one),
        median(all) / median(one)
    );
}

fn sorted(values: &[f64]) -> Vec<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted
}
