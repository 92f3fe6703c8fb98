//! Skinning decomposition: time and error at some numbers of bones, mixed weights and the animation's alone.
//!
//! `cargo bench --bench decompose -- [SEQ…]`; without sequences a bending tube of the bench's own.
#![allow(missing_docs)]

#[path = "shared/tube.rs"]
mod tube;

use std::{error::Error, path::PathBuf, time::Instant};

use dermis::{
    asset::{Room, Sequence, load_sequence},
    sphere_mesh::{Decomposing, Options, Weighting, build, bytes_a_vertex, decompose},
};

use tube::tube;

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
        let sequence = load_sequence(&file, Room::available(bytes_a_vertex))?;
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
