//! Kernels interleaved on real characters: least and median GPU time of every pass, so that two kernels can be compared
//! on a machine that other work shares.
//!
//! `cargo bench --bench frame -- [FRAMES] [FILE…]`; without files the project's own assets.
#![allow(missing_docs)]

use std::{collections::BTreeMap, error::Error, path::PathBuf, sync::Arc};

use dermis::{
    asset,
    deformer::{Deformer, Device, Method, Settings},
    gpu::{Gpu, GpuOptions, Profile},
    report::FrameTimings,
    rig::{self, Pose, Rig},
};

const METHODS: [Method; 3] = [Method::Lbs, Method::Dqs, Method::Implicit];
const FRAMES: usize = 40;
const WARM_UP: usize = 4;
const DEGREES: f32 = 45.0;

type Times = BTreeMap<(usize, String), Vec<u64>>;

fn main() -> Result<(), Box<dyn Error>> {
    let (frames, files) = arguments();
    let gpu = Gpu::new(&GpuOptions {
        profile: Profile::Full,
        ..GpuOptions::default()
    })?;
    let device = gpu.report();
    println!("{} ({}), {frames} frames", device.name, device.driver);
    for file in files {
        let model = asset::load(&file)?;
        let rig = Rig::prepare(&model, &rig::Options::default(), &|_| {})?;
        print(
            &file,
            rig.mesh.positions.len(),
            &measure(&gpu, Arc::new(rig), frames)?,
        );
    }
    Ok(())
}

/// Cargo adds `--bench`; options are not ours.
fn arguments() -> (usize, Vec<PathBuf>) {
    let mut frames = FRAMES;
    let mut files = Vec::new();
    for argument in std::env::args().skip(1).filter(|a| !a.starts_with('-')) {
        match argument.parse() {
            Ok(count) => frames = count,
            Err(_) => files.push(argument.into()),
        }
    }
    if files.is_empty() {
        let assets = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("assets");
        files = ["arm", "hand", "mannequin"]
            .map(|name| assets.join(name).with_extension("glb"))
            .into();
    }
    (frames.max(1), files)
}

/// Plays every pose by every method before the next pose.
fn measure(gpu: &Gpu, rig: Arc<Rig>, frames: usize) -> dermis::Result<Times> {
    let deformer = |method| {
        let settings = Settings {
            method,
            ..Settings::default()
        };
        Deformer::new(&Device::Gpu(gpu.clone()), Arc::clone(&rig), &settings)
    };
    let mut deformers: Vec<Deformer> = METHODS
        .into_iter()
        .map(deformer)
        .collect::<Result<_, _>>()?;
    let mut times = Times::new();
    for frame in 0..WARM_UP + frames {
        let pose = Pose::random(&rig.skeleton, DEGREES, frame as u64)?;
        for (method, deformer) in deformers.iter_mut().enumerate() {
            deformer.advance(&pose)?;
            deformer.wait()?;
            if let (true, Some(timings)) = (frame >= WARM_UP, deformer.timings()) {
                add(&mut times, method, &timings);
            }
        }
    }
    Ok(times)
}

fn add(times: &mut Times, method: usize, timings: &FrameTimings) {
    for (pass, _, ns) in timings.by_name() {
        times.entry((method, pass.into())).or_default().push(ns);
    }
    // "~" sorts behind every pass.
    let frame = times.entry((method, "~frame".into())).or_default();
    frame.push(timings.gpu_ns);
}

fn print(file: &std::path::Path, vertices: usize, times: &Times) {
    println!("\n{}: {vertices} welded vertices", file.display());
    println!(
        "{:<24}{:>10}{:>10}{:>14}",
        "", "min ms", "p50 ms", "ns a vertex"
    );
    for ((method, pass), ns) in times {
        let mut ns = ns.clone();
        ns.sort_unstable();
        let (min, median) = (ns[0] as f64, ns[ns.len() / 2] as f64);
        let name = format!(
            "{} {}",
            METHODS[*method].name(),
            pass.trim_start_matches('~')
        );
        let per_vertex = min / vertices as f64;
        println!(
            "{name:<24}{:>10.3}{:>10.3}{per_vertex:>14.1}",
            min / 1e6,
            median / 1e6
        );
    }
}
