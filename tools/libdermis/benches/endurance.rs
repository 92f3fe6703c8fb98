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
use stage::{Stage, adopt, load, resident};

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
    let mut tenths: [Vec<u64>; 10] = Default::default();
    println!("{:>8}{:>8}{:>16}", "s", "rounds", "resident KiB");
    while begin.elapsed() < time {
        round(&host, rounds);
        rounds += 1;
        let (spent, resident) = (begin.elapsed(), resident());
        let share = spent.as_secs_f64() / time.as_secs_f64();
        let tenth = ((10.0 * share) as usize).min(9);
        tenths[tenth].push(resident);
        if f64::from(told) <= share * f64::from(ROWS) {
            println!("{:>8.0}{rounds:>8}{resident:>16}", spent.as_secs_f64());
            told += 1;
        }
    }
    host.end();
    // Single rounds differ by what the driver's threads happen to keep: medians tell a trend.
    let [first, last] = [1, 9].map(|tenth| {
        let rows: &mut Vec<u64> = &mut tenths[tenth];
        rows.sort_unstable();
        rows.get(rows.len() / 2).copied().unwrap_or(0)
    });
    let growth = last as f64 / first as f64 - 1.0;
    println!(
        "{rounds} rounds; median of the second tenth {first} KiB, of the last {last} KiB: {:+.2} %",
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
