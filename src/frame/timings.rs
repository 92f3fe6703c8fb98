//! From timestamps to timings.

use crate::report::{FrameTimings, PassTiming};

use super::{Frame, SlotState};

/// Timestamps of one submission.
#[derive(Default)]
pub(super) struct Stamps {
    /// Number of the submission, 0 for none.
    pub(super) submission: u64,
    /// Rows of the recorded steps.
    pub(super) steps: Vec<u32>,
    /// One more than steps.
    pub(super) ticks: Vec<u64>,
    /// Recording on the CPU.
    pub(super) cpu_record_ns: u64,
}

impl Stamps {
    pub(super) fn with_capacity(steps: usize) -> Self {
        Self {
            steps: Vec::with_capacity(steps),
            ticks: Vec::with_capacity(steps + 1),
            ..Self::default()
        }
    }

    /// Takes over the timestamps of a slot whose submission is done.
    pub(super) fn take(&mut self, slot: &SlotState) {
        let Some(timestamps) = slot.timestamps.as_ref().filter(|_| slot.timed) else {
            return;
        };
        if slot.submission <= self.submission {
            return;
        }
        self.ticks.clear();
        self.ticks.resize(slot.recorded.len() + 1, 0);
        self.submission = 0;
        if timestamps.read(&mut self.ticks) {
            self.steps.clone_from(&slot.recorded);
            (self.submission, self.cpu_record_ns) = (slot.submission, slot.cpu_record_ns);
        }
    }
}

impl Frame {
    /// When the steps of the last completed submission ran; `None` before the first, or where no timestamps are taken.
    pub fn timings(&self) -> Option<FrameTimings> {
        let shared = &self.gpu.shared;
        let done = shared.queue.completed(&shared.device);
        let ready = self
            .slots
            .iter()
            .filter(|s| s.submission <= done && s.timed);
        let newest = ready.max_by_key(|s| s.submission);
        let mut fresh = Stamps::default();
        if let Some(slot) = newest.filter(|s| s.submission > self.harvest.submission) {
            fresh.take(slot);
        }
        let stamps = if fresh.submission > 0 {
            &fresh
        } else {
            &self.harvest
        };
        (stamps.submission > 0).then(|| self.report(stamps))
    }

    fn report(&self, stamps: &Stamps) -> FrameTimings {
        let ns: Vec<_> = stamps
            .ticks
            .iter()
            .map(|t| self.gpu.shared.nanoseconds(*t))
            .collect();
        let passes = stamps.steps.iter().zip(ns.windows(2)).map(|(row, ns)| {
            let step = &self.steps[*row as usize];
            PassTiming {
                name: step.name.clone(),
                label: step.label.to_string_lossy().into_owned(),
                begin_ns: ns[0],
                end_ns: ns[1],
            }
        });
        FrameTimings {
            passes: passes.collect(),
            gpu_ns: ns
                .last()
                .zip(ns.first())
                .map_or(0, |(end, begin)| end.saturating_sub(*begin)),
            cpu_record_ns: stamps.cpu_record_ns,
        }
    }
}
