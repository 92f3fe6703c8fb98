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
    pub(super) empty: Empty,
    /// Recording on the CPU.
    pub(super) cpu_record_ns: u64,
}

/// Ticks between the last two timestamps of a few submissions, with nothing between them: the cost of one.
#[derive(Clone, Copy, Default)]
pub(super) struct Empty {
    ticks: [u64; 15],
    seen: usize,
}

impl Empty {
    fn add(&mut self, ticks: u64) {
        self.ticks[self.seen % self.ticks.len()] = ticks;
        self.seen += 1;
    }

    /// The median: a thread that was taken off its core in one of them says nothing of the others.
    fn cost(mut self) -> u64 {
        let seen = self.seen.min(self.ticks.len());
        self.ticks[..seen].sort_unstable();
        self.ticks[seen / 2]
    }
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
                self.empty.add(empty.wrapping_sub(end));
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
        let cost = shared.nanoseconds(stamps.empty.cost());
        let (end, spans) = match ns[..] {
            [.., end, _] => (end, ns.len() as u64 - 2),
            _ => (0, 0),
        };
        let begin = ns.first().copied().unwrap_or(end);
        let passes = stamps.intervals.iter().map(|interval| {
            let step = &self.program.steps[interval.row as usize];
            let stamp = interval.stamp as usize;
            PassTiming {
                name: self.names[step.name_row as usize].clone(),
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_timestamp_costs_the_median_of_the_last_empty_intervals() {
        let mut empty = Empty::default();
        assert_eq!(empty.cost(), 0);
        empty.add(7);
        assert_eq!(empty.cost(), 7);
        empty.add(3);
        empty.add(9_000_000);
        assert_eq!(empty.cost(), 7);
        (20..35).for_each(|ticks| empty.add(ticks));
        assert_eq!(empty.cost(), 27);
    }
}
