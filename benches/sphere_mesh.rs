//! Building a sphere-mesh: time a vertex and frame at four sizes of mesh and three numbers of frames, and how it grows.
//!
//! `cargo bench --bench sphere_mesh -- [SEQ…]`; without sequences a bending tube of the bench's own.
#![allow(missing_docs)]

#[path = "shared/tube.rs"]
mod tube;

use std::{error::Error, path::PathBuf, time::Instant};

use dermis::{
    asset::{Room, Sequence, load_sequence},
    sphere_mesh::{Options, build, bytes_a_vertex},
};

use tube::tube;

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
        for (rings, around) in [(50, 40), (100, 80), (200, 160), (400, 320)] {
            measure("tube", &tube(rings, around, 48))?;
        }
        for frames in [12, 48, 192] {
            measure("tube", &tube(100, 80, frames))?;
        }
    }
    for file in files {
        let sequence = load_sequence(&file, Room::available(bytes_a_vertex))?;
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
