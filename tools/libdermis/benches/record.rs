//! CPU time of recording a steady frame by dm_frame_record, least, median and 95th percentile, by every method.
//!
//! The thread's own time: a driver that computes on the CPU takes the core away in between.
//!
//! `cargo bench --package dermis-c --bench record -- [FRAMES] [CHARACTER…]`; characters are those of `assets`.
#![allow(missing_docs, clippy::unwrap_used)]

#[allow(dead_code, reason = "the tests use the rest")]
#[path = "../tests/abi/host_device.rs"]
mod host_device;
#[path = "../tests/shared/stage.rs"]
mod stage;

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
        "{:<12}{:<16}{:>10}{:>8}{:>8}{:>8}{:>16}{:>8}{:>8}",
        "", "", "sub-steps", "min", "p50", "p95", "min", "p50", "p95"
    );
    for character in &characters {
        for (name, method, turn) in METHODS {
            let stage = Stage::new(&host, character, method);
            let poses: Vec<_> = (0..10).map(|k| stage.turned(turn * k as f32)).collect();
            let played = measure(&stage, &poses, frames, |record| host.run(record));
            let substeps = stage.iterations().substeps;
            let alone = measure(&stage, &poses, frames, |record| host.record(record));
            let [[a, b, c], [d, e, f]] = [played, alone];
            println!(
                "{character:<12}{name:<16}{substeps:>10}{a:>8.1}{b:>8.1}{c:>8.1}{d:>16.1}{e:>8.1}{f:>8.1}"
            );
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

/// Swings to and fro; gives the least time, the median and the 95th percentile, in microseconds.
fn measure(
    stage: &Stage<'_>,
    poses: &[Vec<f32>],
    frames: usize,
    run: impl Fn(&mut dyn FnMut()),
) -> [f64; 3] {
    let rows = 0..poses.len();
    let to_and_fro = rows.clone().chain(rows.rev()).cycle();
    let mut ns = Vec::with_capacity(WARM_UP + frames);
    for (frame, row) in to_and_fro.take(WARM_UP + frames).enumerate() {
        run(&mut || {
            let begin = on_the_cpu();
            stage.record(frame as u32 % 2, &poses[row]);
            ns.push(on_the_cpu() - begin);
        });
    }
    let mut ns = ns.split_off(WARM_UP);
    ns.sort_unstable();
    [0, ns.len() / 2, ns.len() * 95 / 100].map(|k| ns[k] as f64 / 1e3)
}

/// Nanoseconds that this thread has run.
#[cfg(unix)]
fn on_the_cpu() -> i64 {
    let time = rustix::time::clock_gettime(rustix::time::ClockId::ThreadCPUTime);
    time.tv_sec * 1_000_000_000 + time.tv_nsec
}

/// Nanoseconds since the first call, where a thread's own cannot be asked for.
#[cfg(not(unix))]
fn on_the_cpu() -> i64 {
    static START: std::sync::OnceLock<std::time::Instant> = std::sync::OnceLock::new();
    START
        .get_or_init(std::time::Instant::now)
        .elapsed()
        .as_nanos() as i64
}
