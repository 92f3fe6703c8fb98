//! Building a sphere-mesh: time a vertex and frame at three sizes of mesh and three numbers of frames, and how it grows.
//!
//! `cargo bench --bench sphere_mesh -- [SEQ…]`; without sequences a bending tube of the bench's own.
#![allow(missing_docs)]

use std::{error::Error, path::PathBuf, time::Instant};

use dermis::{
    asset::{Room, Sequence, load_sequence},
    sphere_mesh::{BYTES_EACH, Options, build},
};
use glam::{Quat, Vec3};

/// Each figure is the least of this many.
const TRIES: usize = 3;

fn main() -> Result<(), Box<dyn Error>> {
    let threads = rayon::current_num_threads();
    println!("{threads} threads; least of {TRIES}; us a vertex and frame");
    let files: Vec<PathBuf> = std::env::args()
        .skip(1)
        .filter(|a| !a.starts_with('-'))
        .map(PathBuf::from)
        .collect();
    if files.is_empty() {
        for (rings, around) in [(50, 40), (100, 80), (200, 160)] {
            measure("tube", &tube(rings, around, 48))?;
        }
        for frames in [12, 48, 192] {
            measure("tube", &tube(100, 80, frames))?;
        }
    }
    for file in files {
        let sequence = load_sequence(&file, Room::available(BYTES_EACH))?;
        measure(&file.display().to_string(), &sequence)?;
    }
    Ok(())
}

fn measure(name: &str, sequence: &Sequence) -> Result<(), Box<dyn Error>> {
    let options = Options::default();
    let mut best = f64::INFINITY;
    for _ in 0..TRIES {
        let begin = Instant::now();
        let hierarchy = build(sequence, &options, &|_| {})?;
        best = best.min(begin.elapsed().as_secs_f64());
        std::hint::black_box(hierarchy);
    }
    let (vertices, frames) = (sequence.frames[0].len(), sequence.frames.len());
    let each = 1e6 * best / (vertices * frames) as f64;
    println!(
        "{name}: {vertices} vertices, {frames} frames: {best:.3} s, {each:.3} us; {}",
        memory()
    );
    Ok(())
}

/// Peak of the whole process so far.
fn memory() -> String {
    let text = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let peak = text.lines().find(|l| l.starts_with("VmHWM"));
    peak.unwrap_or("no figure of memory").replace('\t', " ")
}

/// A tube that bends more from frame to frame.
fn tube(rings: usize, around: usize, frames: usize) -> Sequence {
    let bent = |turn: f32| {
        let point = |i: usize| {
            let t = (i / around) as f32 / (rings - 1) as f32 * 2.0 - 1.0;
            let a = (i % around) as f32 / around as f32 * std::f32::consts::TAU;
            let r = 0.2 + 0.05 * (7.0 * t).sin();
            Quat::from_rotation_z(turn * t.max(0.0)) * Vec3::new(t, r * a.cos(), r * a.sin())
        };
        (0..rings * around).map(point).collect()
    };
    let (n, m) = (around as u32, rings as u32);
    let quads = (0..m - 1).flat_map(|i| (0..n).map(move |k| (i, k)));
    let triangles = quads.flat_map(|(i, k)| {
        let next = (k + 1) % n;
        let [a, b, c, d] = [i * n + k, i * n + next, (i + 1) * n + k, (i + 1) * n + next];
        [[a, b, c], [b, d, c]]
    });
    Sequence {
        path: "tube".into(),
        triangles: triangles.collect(),
        frames: (0..frames)
            .map(|f| bent(f as f32 / frames as f32))
            .collect(),
    }
}
