//! Times of many frames, pass by pass.

use dermis::{
    Result,
    deformer::Deformer,
    report::{FrameTimings, Iterations},
    rig::Pose,
};
use std::time::Instant;

use crate::stats::Spread;

/// What was measured in a run of frames.
#[derive(Clone, Debug, Default)]
pub(crate) struct Samples {
    passes: Vec<Pass>,
    pub(crate) gpu_ns: Vec<u64>,
    pub(crate) cpu_record_ns: Vec<u64>,
    pub(crate) wall_ns: Vec<u64>,
    pub(crate) iterations: Vec<Iterations>,
}

/// A pass over all frames; a frame's calls are added up.
#[derive(Clone, Debug)]
pub(crate) struct Pass {
    pub(crate) name: String,
    pub(crate) calls: Vec<u64>,
    pub(crate) ns: Vec<u64>,
}

impl Samples {
    /// Plays `pose` to its end and keeps what it took.
    pub(crate) fn play(&mut self, deformer: &mut Deformer, pose: &Pose) -> Result<()> {
        let begin = Instant::now();
        deformer.advance(pose)?;
        deformer.wait()?;
        self.wall_ns.push(begin.elapsed().as_nanos() as u64);
        match deformer.timings() {
            Some(timings) => self.add(&timings),
            None => self.cpu_record_ns.push(deformer.record_ns()),
        }
        self.iterations.push(deformer.iterations()?);
        Ok(())
    }

    fn add(&mut self, timings: &FrameTimings) {
        self.gpu_ns.push(timings.gpu_ns);
        self.cpu_record_ns.push(timings.cpu_record_ns);
        let frame = self.gpu_ns.len() - 1;
        for timing in &timings.passes {
            let pass = self.pass(&timing.name);
            // A pass that is missing in some frames took no time there.
            pass.calls.resize(frame + 1, 0);
            pass.ns.resize(frame + 1, 0);
            pass.calls[frame] += 1;
            pass.ns[frame] += timing.end_ns.saturating_sub(timing.begin_ns);
        }
    }

    fn pass(&mut self, name: &str) -> &mut Pass {
        let row = self.passes.iter().position(|p| p.name == name);
        let row = row.unwrap_or_else(|| {
            self.passes.push(Pass {
                name: name.into(),
                calls: Vec::new(),
                ns: Vec::new(),
            });
            self.passes.len() - 1
        });
        &mut self.passes[row]
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
            begin_ns,
            end_ns,
        }
    }

    #[test]
    fn calls_of_a_frame_add_up_and_absent_passes_take_no_time() {
        let mut samples = Samples::default();
        let first = vec![
            timing("project", 0, 2_000_000),
            timing("project", 3_000_000, 4_000_000),
        ];
        let second = vec![timing("relax", 0, 1_000_000)];
        for passes in [first, second] {
            samples.add(&FrameTimings {
                passes,
                gpu_ns: 5_000_000,
                cpu_record_ns: 1,
            });
        }
        let ns: Vec<_> = samples
            .passes()
            .map(|p| (p.name.as_str(), p.ns.clone()))
            .collect();
        assert_eq!(
            ns,
            [("project", vec![3_000_000]), ("relax", vec![0, 1_000_000])]
        );
    }
}
