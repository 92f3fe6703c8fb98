//! Skinning decomposition: time and error at some numbers of bones, mixed weights and the animation's alone.
//!
//! `cargo bench --bench decompose -- [SEQ…]`; without sequences a bending tube of the bench's own.
#![allow(missing_docs)]

use std::{error::Error, path::PathBuf, time::Instant};

use dermis::{
    asset::{Room, Sequence, load_sequence},
    sphere_mesh::{BYTES_EACH, Decomposing, Options, Weighting, build, decompose},
};
use glam::{Quat, Vec3};

/// Each time is the least of this many.
const TRIES: usize = 3;

fn main() -> Result<(), Box<dyn Error>> {
    let threads = rayon::current_num_threads();
    println!("{threads} threads; least of {TRIES}");
    let files: Vec<PathBuf> = std::env::args()
        .skip(1)
        .filter(|a| !a.starts_with('-'))
        .map(PathBuf::from)
        .collect();
    if files.is_empty() {
        measure("tube", &tube(100, 80, 48))?;
    }
    for file in files {
        let sequence = load_sequence(&file, Room::available(BYTES_EACH))?;
        measure(&file.display().to_string(), &sequence)?;
    }
    Ok(())
}

fn measure(name: &str, sequence: &Sequence) -> Result<(), Box<dyn Error>> {
    let hierarchy = build(sequence, &Options::default(), &|_| {})?;
    let clips = std::slice::from_ref(sequence);
    for spheres in [25, 30, 46] {
        let level = hierarchy.level(spheres)?.optimised(&hierarchy);
        for weighting in [Weighting::Mixed, Weighting::Animation] {
            let options = Decomposing {
                weighting,
                ..Decomposing::default()
            };
            let (mut best, mut last) = (f64::INFINITY, None);
            for _ in 0..TRIES {
                let begin = Instant::now();
                last = Some(decompose(&hierarchy, &level, clips, &options, &|_| {})?);
                best = best.min(begin.elapsed().as_secs_f64());
            }
            let Some(result) = last else { continue };
            println!(
                "{name}, {spheres} spheres, {weighting:?}: {best:.2} s, {} iterations, E_RMS {:.3}",
                result.iterations, result.e_rms
            );
        }
    }
    Ok(())
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
