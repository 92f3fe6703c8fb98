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
    /// Least ticks that any submission had between its last two timestamps, with nothing between them: the cost of one.
    pub(super) empty: Option<u64>,
    /// Recording on the CPU.
    pub(super) cpu_record_ns: u64,
}

impl Stamps {
    pub(super) fn with_capacity(steps: usize) -> Self {
        Self {
            intervals: Vec::with_capacity(steps),
            ticks: Vec::with_capacity(steps + 3),
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
            if let [.., end, empty] = self.ticks[..] {
                let cost = empty.wrapping_sub(end);
                self.empty = Some(self.empty.map_or(cost, |least| least.min(cost)));
            }
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
        let mut fresh = Stamps {
            empty: self.harvest.empty,
            ..Stamps::default()
        };
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

    /// Between two timestamps lies what one of them costs, which is no step's time.
    fn report(&self, stamps: &Stamps) -> FrameTimings {
        let shared = &self.gpu.shared;
        let ns: Vec<_> = stamps
            .ticks
            .iter()
            .map(|t| shared.nanoseconds(*t))
            .collect();
        let cost = shared.nanoseconds(stamps.empty.unwrap_or(0));
        let (end, spans) = match ns[..] {
            [.., end, _] => (end, ns.len() as u64 - 2),
            _ => (0, 0),
        };
        let begin = ns.first().copied().unwrap_or(end);
        let passes = stamps.intervals.iter().map(|interval| {
            let step = &self.steps[interval.row as usize];
            let stamp = interval.stamp as usize;
            PassTiming {
                name: step.name.clone(),
                label: step.label.to_string_lossy().into_owned(),
                steps: interval.steps,
                begin_ns: ns[stamp],
                end_ns: ns[stamp + 1].saturating_sub(cost).max(ns[stamp]),
            }
        });
        FrameTimings {
            passes: passes.collect(),
            gpu_ns: end.saturating_sub(begin + spans * cost),
            stamp_ns: cost,
            turns: stamps.turns,
            cpu_record_ns: stamps.cpu_record_ns,
        }
    }
}
