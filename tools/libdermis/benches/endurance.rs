//! Characters are made, animated and destroyed through the C interface for a while: memory must not grow.
//!
//! `cargo bench --package dermis-c --bench endurance -- [MINUTES]`; fails where the resident memory grows by more than 1 % after
//! the first tenth of the time.
#![allow(missing_docs, clippy::unwrap_used)]

#[allow(dead_code, reason = "the tests use the rest")]
#[path = "../tests/abi/host_device.rs"]
mod host_device;
#[path = "../tests/shared/stage.rs"]
mod stage;

use std::{
    process::ExitCode,
    time::{Duration, Instant},
};

use dermis::capi::*;

use host_device::HostDevice;
use stage::{Stage, adopt, load};

const MINUTES: f64 = 10.0;
const FRAMES: usize = 4;
/// Most growth, as a share.
const GROWTH: f64 = 0.01;
/// Rows of the report.
const ROWS: u32 = 20;

fn main() -> ExitCode {
    let minutes = std::env::args().skip(1).find_map(|a| a.parse().ok());
    let time = Duration::from_secs_f64(60.0 * minutes.unwrap_or(MINUTES));
    let host = HostDevice::with_layers(&[]);
    let begin = Instant::now();
    let (mut rounds, mut told) = (0u32, 0);
    // Most resident memory in each tenth of the time.
    let mut most = [0u64; 10];
    println!("{:>8}{:>8}{:>16}", "s", "rounds", "resident KiB");
    while begin.elapsed() < time {
        round(&host, rounds);
        rounds += 1;
        let (spent, resident) = (begin.elapsed(), resident());
        let share = spent.as_secs_f64() / time.as_secs_f64();
        let tenth = ((10.0 * share) as usize).min(9);
        most[tenth] = most[tenth].max(resident);
        if f64::from(told) <= share * f64::from(ROWS) {
            println!("{:>8.0}{rounds:>8}{resident:>16}", spent.as_secs_f64());
            told += 1;
        }
    }
    host.end();
    let (first, last) = (most[1], most[9]);
    let growth = last as f64 / first as f64 - 1.0;
    println!(
        "{rounds} rounds; most in the second tenth {first} KiB, in the last {last} KiB: {:+.2} %",
        100.0 * growth
    );
    ExitCode::from(u8::from(growth > GROWTH))
}

/// A context, a character and deformers by every method, from the first call to the last.
fn round(host: &HostDevice, round: u32) {
    let characters = ["arm", "hand"];
    let methods = [DM_LBS, DM_DQS, DM_IMPLICIT, DM_TRACKING];
    let character = characters[round as usize % characters.len()];
    for method in methods {
        let stage = Stage::of(host, adopt(host), load(character), method);
        for frame in 0..FRAMES {
            let pose = stage.turned(20.0 * frame as f32);
            host.run(|| stage.record(frame as u32 % 2, &pose));
        }
        stage.read();
        stage.save_and_restore();
        stage.iterations();
        stage.end();
    }
}

/// Resident memory of this process in KiB.
fn resident() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap();
    let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:"));
    let number = line.unwrap().trim().trim_end_matches(" kB");
    number.parse().unwrap()
}
