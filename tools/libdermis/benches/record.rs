//! CPU time of recording a steady frame by dm_frame_record, least and median, by every method.
//!
//! `cargo bench --package dermis-c --bench record -- [FRAMES] [CHARACTER…]`; characters are those of `assets`.
#![allow(missing_docs, clippy::unwrap_used)]

#[allow(dead_code, reason = "the tests use the rest")]
#[path = "../tests/abi/host_device.rs"]
mod host_device;
#[path = "../tests/shared/stage.rs"]
mod stage;

use std::time::Instant;

use dermis::capi::*;

use host_device::HostDevice;
use stage::Stage;

const FRAMES: usize = 500;
const WARM_UP: usize = 20;
/// What a method is called, its number, and by how much every joint turns from frame to frame, in degrees.
const METHODS: [(&str, u32, f32); 5] = [
    ("lbs", DM_LBS, 3.0),
    ("dqs", DM_DQS, 3.0),
    ("implicit", DM_IMPLICIT, 3.0),
    ("tracking", DM_TRACKING, 3.0),
    ("tracking, fast", DM_TRACKING, 12.0),
];

fn main() {
    let (frames, characters) = arguments();
    let host = HostDevice::with_layers(&[]);
    println!(
        "{frames} frames; µs on the CPU to record one, frame after frame, and without frames in between"
    );
    println!(
        "{:<12}{:<16}{:>10}{:>8}{:>8}{:>16}{:>8}",
        "", "", "sub-steps", "min", "p50", "min", "p50"
    );
    for character in &characters {
        for (name, method, turn) in METHODS {
            let stage = Stage::new(&host, character, method);
            let poses: Vec<_> = (0..10).map(|k| stage.turned(turn * k as f32)).collect();
            let played = measure(&stage, &poses, frames, |record| host.run(record));
            let substeps = stage.iterations().substeps;
            let alone = measure(&stage, &poses, frames, |record| host.record(record));
            let [a, b, c, d] = [played.0, played.1, alone.0, alone.1];
            println!("{character:<12}{name:<16}{substeps:>10}{a:>8.1}{b:>8.1}{c:>16.1}{d:>8.1}");
            stage.end();
        }
    }
    host.end();
}

/// Cargo adds `--bench`; options are not ours.
fn arguments() -> (usize, Vec<String>) {
    let (mut frames, mut characters) = (FRAMES, Vec::new());
    for argument in std::env::args().skip(1).filter(|a| !a.starts_with('-')) {
        match argument.parse() {
            Ok(count) => frames = count,
            Err(_) => characters.push(argument),
        }
    }
    if characters.is_empty() {
        characters = ["arm", "hand", "mannequin"].map(String::from).to_vec();
    }
    (frames.max(1), characters)
}

/// Swings to and fro; gives the least and the median time in microseconds.
fn measure(
    stage: &Stage<'_>,
    poses: &[Vec<f32>],
    frames: usize,
    run: impl Fn(&mut dyn FnMut()),
) -> (f64, f64) {
    let rows = 0..poses.len();
    let to_and_fro = rows.clone().chain(rows.rev()).cycle();
    let mut ns = Vec::with_capacity(WARM_UP + frames);
    for (frame, row) in to_and_fro.take(WARM_UP + frames).enumerate() {
        run(&mut || {
            let begin = Instant::now();
            stage.record(frame as u32 % 2, &poses[row]);
            ns.push(begin.elapsed().as_nanos() as u64);
        });
    }
    let mut ns = ns.split_off(WARM_UP);
    ns.sort_unstable();
    let us = |ns: u64| ns as f64 / 1e3;
    (us(ns[0]), us(ns[ns.len() / 2]))
}
