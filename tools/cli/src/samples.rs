//! Times of many frames, pass by pass.

use dermis::{
    Result,
    deformer::Deformer,
    report::{FrameTimings, Iterations},
    rig::Pose,
};
use std::time::Instant;

use crate::stats::Spread;

/// Steps that are no dispatches and have no state to set up anew.
const TRANSFERS: [&str; 2] = ["fill", "copy"];

/// What was measured in a run of frames.
#[derive(Clone, Debug, Default)]
pub(crate) struct Samples {
    passes: Vec<Pass>,
    /// Frames in a row that time every pass.
    pub(crate) turns: usize,
    /// What a timestamp costs; taken off all times.
    pub(crate) stamp_ns: u64,
    /// What timed calls take longer than untimed ones, beyond the timestamp; taken off every interval.
    pub(crate) excess_ns: u64,
    /// Of the frames that time no pass, which are the undisturbed ones; of all where every frame times one.
    pub(crate) gpu_ns: Vec<u64>,
    disturbed_gpu_ns: Vec<u64>,
    pub(crate) cpu_record_ns: Vec<u64>,
    pub(crate) wall_ns: Vec<u64>,
    pub(crate) iterations: Vec<Iterations>,
}

/// A pass in the frames that timed it; a frame's calls are added up.
#[derive(Clone, Debug)]
pub(crate) struct Pass {
    pub(crate) name: String,
    /// Rows of the frames.
    pub(crate) frames: Vec<usize>,
    pub(crate) calls: Vec<u64>,
    /// Runs of calls between two timestamps.
    intervals: Vec<u64>,
    pub(crate) ns: Vec<u64>,
}

/// Plays a frame, a pose an instance, to its end; wall-clock nanoseconds.
pub(crate) fn play(deformer: &mut Deformer, poses: &[Pose]) -> Result<u64> {
    let begin = Instant::now();
    deformer.advance(poses)?;
    deformer.wait()?;
    Ok(begin.elapsed().as_nanos() as u64)
}

impl Samples {
    /// Plays a frame, a pose an instance, to its end and keeps what it took.
    pub(crate) fn play(&mut self, deformer: &mut Deformer, poses: &[Pose]) -> Result<()> {
        self.wall_ns.push(play(deformer, poses)?);
        match deformer.timings() {
            Some(timings) => self.add(&timings),
            None => self.cpu_record_ns.push(deformer.record_ns()),
        }
        self.iterations.push(deformer.iterations()?);
        Ok(())
    }

    fn add(&mut self, timings: &FrameTimings) {
        self.turns = timings.turns as usize;
        self.stamp_ns = timings.stamp_ns;
        let gpu_ns = if timings.passes.is_empty() {
            &mut self.gpu_ns
        } else {
            &mut self.disturbed_gpu_ns
        };
        gpu_ns.push(timings.gpu_ns);
        self.cpu_record_ns.push(timings.cpu_record_ns);
        let frame = self.cpu_record_ns.len() - 1;
        for (name, calls, ns) in timings.by_name() {
            let pass = self.pass(name);
            pass.frames.push(frame);
            pass.calls.push(calls as u64);
            let intervals = timings.passes.iter().filter(|p| p.name == name);
            pass.intervals.push(intervals.count() as u64);
            pass.ns.push(ns);
        }
    }

    /// Takes the excess off every interval, once all frames are played.
    pub(crate) fn take_off(&mut self, excess_ns: u64) {
        self.excess_ns = excess_ns;
        let dispatched = |pass: &&mut Pass| !TRANSFERS.contains(&pass.name.as_str());
        for pass in self.passes.iter_mut().filter(dispatched) {
            for (ns, intervals) in pass.ns.iter_mut().zip(&pass.intervals) {
                *ns = ns.saturating_sub(excess_ns * intervals);
            }
        }
        if self.gpu_ns.is_empty() {
            self.gpu_ns.append(&mut self.disturbed_gpu_ns);
        }
    }

    fn pass(&mut self, name: &str) -> &mut Pass {
        let row = self.passes.iter().position(|p| p.name == name);
        let row = row.unwrap_or_else(|| {
            self.passes.push(Pass {
                name: name.into(),
                frames: Vec::new(),
                calls: Vec::new(),
                intervals: Vec::new(),
                ns: Vec::new(),
            });
            self.passes.len() - 1
        });
        &mut self.passes[row]
    }

    /// Fetches a second of the projection, one a frame that timed it; least first.
    pub(crate) fn fetch_rates(&self) -> Vec<f64> {
        let project = self.passes.iter().filter(|p| p.name == "project");
        let timed = project.flat_map(|p| p.frames.iter().zip(&p.ns));
        let rate = |(&frame, &ns): (&usize, &u64)| {
            let fetches = self.iterations.get(frame)?.fetches;
            (fetches > 0 && ns > 0).then(|| fetches as f64 * 1e9 / ns as f64)
        };
        let mut rates: Vec<f64> = timed.filter_map(rate).collect();
        rates.sort_by(f64::total_cmp);
        rates
    }

    /// All passes in the order of their first appearance.
    pub(crate) fn passes(&self) -> impl Iterator<Item = &Pass> {
        self.passes.iter()
    }
}

impl Pass {
    /// Median of the calls a frame.
    pub(crate) fn calls(&self) -> u64 {
        let mut calls = self.calls.clone();
        calls.sort_unstable();
        calls.get(calls.len() / 2).copied().unwrap_or(0)
    }

    pub(crate) fn spread(&self) -> Spread {
        Spread::of_ns(&self.ns)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use dermis::report::PassTiming;

    fn timing(name: &str, begin_ns: u64, end_ns: u64) -> PassTiming {
        PassTiming {
            name: name.into(),
            label: name.into(),
            steps: 1,
            begin_ns,
            end_ns,
        }
    }

    /// Two frames: one that timed the projection, one that timed the relaxation.
    fn two_frames() -> Samples {
        let mut samples = Samples::default();
        let first = vec![
            timing("project", 0, 2_000_000),
            timing("project", 3_000_000, 4_000_000),
        ];
        let second = vec![timing("relax", 0, 1_000_000)];
        for passes in [first, second] {
            samples.add(&FrameTimings {
                passes,
                turns: 2,
                stamp_ns: 0,
                gpu_ns: 5_000_000,
                cpu_record_ns: 1,
            });
        }
        samples
    }

    #[test]
    fn calls_of_a_frame_add_up_and_frames_that_do_not_time_a_pass_do_not_count() {
        let samples = two_frames();
        let passes: Vec<_> = samples
            .passes()
            .map(|p| (p.name.as_str(), p.calls(), p.frames[0], p.ns.clone()))
            .collect();
        let expected = [
            ("project", 2, 0, vec![3_000_000]),
            ("relax", 1, 1, vec![1_000_000]),
        ];
        assert_eq!(passes, expected);
        assert_eq!(samples.turns, 2);
    }

    #[test]
    fn excess_is_taken_off_intervals_of_dispatches_and_undisturbed_frames_stand_for_all() {
        let mut samples = two_frames();
        samples.add(&FrameTimings {
            passes: vec![timing("fill", 0, 500)],
            turns: 2,
            gpu_ns: 9_000_000,
            ..FrameTimings::default()
        });
        let mut disturbed = samples.clone();
        disturbed.take_off(0);
        assert_eq!(disturbed.gpu_ns, [5_000_000, 5_000_000, 9_000_000]);
        samples.add(&FrameTimings {
            turns: 2,
            gpu_ns: 4_000_000,
            ..FrameTimings::default()
        });
        samples.take_off(600_000);
        // Two intervals of the projection, one of the relaxation; a fill has no excess.
        let ns: Vec<u64> = samples.passes().map(|p| p.ns[0]).collect();
        assert_eq!(ns, [1_800_000, 400_000, 500]);
        assert_eq!(samples.gpu_ns, [4_000_000]);
    }

    #[test]
    fn fetches_are_of_the_frame_that_timed_the_projection() {
        let mut samples = two_frames();
        assert!(samples.fetch_rates().is_empty());
        samples.iterations = [600, 7]
            .map(|fetches| Iterations {
                fetches,
                ..Iterations::default()
            })
            .into();
        let rates = samples.fetch_rates();
        assert!((rates[0] - 2e5).abs() < 1e-6 && rates.len() == 1);
    }
}
