//! From timestamps to timings.

use crate::report::{FrameTimings, PassTiming};

use super::{Frame, SlotState, profile::Interval};

/// Timestamps of one submission.
#[derive(Default)]
pub(super) struct Stamps {
    /// Number of the submission, 0 for none.
    pub(super) submission: u64,
    pub(super) intervals: Vec<Interval>,
    pub(super) ticks: Vec<u64>,
    /// See [`FrameTimings::turns`].
    pub(super) turns: u32,
    /// Recording on the CPU.
    pub(super) cpu_record_ns: u64,
}

impl Stamps {
    pub(super) fn with_capacity(steps: usize) -> Self {
        Self {
            intervals: Vec::with_capacity(steps),
            ticks: Vec::with_capacity(steps + 2),
            ..Self::default()
        }
    }

    /// Takes over the timestamps of a slot whose submission is done.
    pub(super) fn take(&mut self, slot: &SlotState) {
        let Some(timestamps) = slot.timestamps.as_ref().filter(|_| slot.stamps > 0) else {
            return;
        };
        if slot.submission <= self.submission {
            return;
        }
        self.ticks.clear();
        self.ticks.resize(slot.stamps as usize, 0);
        self.submission = 0;
        if timestamps.read(&mut self.ticks) {
            self.intervals.clone_from(&slot.intervals);
            self.turns = slot.turns;
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
            .filter(|s| s.submission <= done && s.stamps > 0);
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
        let passes = stamps.intervals.iter().map(|interval| {
            let step = &self.steps[interval.row as usize];
            let stamp = interval.stamp as usize;
            PassTiming {
                name: step.name.clone(),
                label: step.label.to_string_lossy().into_owned(),
                steps: interval.steps,
                begin_ns: ns[stamp],
                end_ns: ns[stamp + 1],
            }
        });
        FrameTimings {
            passes: passes.collect(),
            gpu_ns: ns
                .last()
                .zip(ns.first())
                .map_or(0, |(end, begin)| end.saturating_sub(*begin)),
            turns: stamps.turns,
            cpu_record_ns: stamps.cpu_record_ns,
        }
    }
}
