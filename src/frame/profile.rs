//! Which steps of a submission stand between timestamps.
//!
//! A timestamp is not free: a software device drains its queue at every one. So [`Profile::Sampled`] times a few names
//! a submission, in turn, and leaves out whole turns after names that need many timestamps.

use std::ops::Range;

use crate::gpu::{Profile, Recorder, Timestamps};

/// Timestamps that a turn may add on average to the three that every frame has. On lavapipe one costs 25 µs: seven are
/// 2 % of a frame of 8 ms.
const STAMPS: u32 = 4;

/// Which names are timed in which submission.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct Turns {
    /// Turn of every name.
    of: Vec<u32>,
    /// Turns until the first comes again; some may belong to no name.
    pub(super) count: u32,
}

impl Turns {
    /// For a frame of steps that have these names, numbered in order of appearance.
    pub(super) fn new(steps: &[u32]) -> Self {
        let names = steps.iter().max().map_or(0, |last| last + 1);
        let (mut of, mut count, mut first) = (Vec::new(), 0, 0);
        while first < names {
            let fits = |end: &u32| stamps(steps, first..*end) <= STAMPS;
            let end = (first + 1..=names).take_while(fits).last();
            let end = end.unwrap_or(first + 1);
            of.resize(end as usize, count);
            count += stamps(steps, first..end).div_ceil(STAMPS).max(1);
            first = end;
        }
        Self {
            of,
            count: count.max(1),
        }
    }

    fn times(&self, name: u32, turn: u32) -> bool {
        self.of.get(name as usize) == Some(&turn)
    }
}

/// Timestamps inside the frame that it takes to time all steps with a name out of `names`.
fn stamps(steps: &[u32], names: Range<u32>) -> u32 {
    let ends = steps.windows(2).filter(|pair| {
        let timed = pair.iter().any(|name| names.contains(name));
        timed && pair[0] != pair[1]
    });
    ends.count() as u32
}

/// Steps between a timestamp and the next.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Interval {
    /// Row of the first step.
    pub(super) row: u32,
    /// Steps, all of the same name.
    pub(super) steps: u32,
    /// Number of the timestamp before.
    pub(super) stamp: u32,
}

/// How a submission is timed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Plan {
    /// The names of this turn.
    Turn(u32),
    /// Every step.
    Full,
}

impl Plan {
    /// None for not at all.
    pub(super) fn new(profile: Profile, turn: u32) -> Option<Self> {
        match profile {
            Profile::Off => None,
            Profile::Sampled => Some(Self::Turn(turn)),
            Profile::Full => Some(Self::Full),
        }
    }

    fn times(self, turns: &Turns, name: u32) -> bool {
        match self {
            Self::Turn(turn) => turns.times(name, turn),
            Self::Full => true,
        }
    }
}

/// Writes the timestamps of a submission while it is recorded.
pub(super) struct Stopwatch<'a> {
    pub(super) plan: Plan,
    pub(super) turns: &'a Turns,
    pub(super) timestamps: &'a Timestamps,
    pub(super) intervals: &'a mut Vec<Interval>,
    /// Timestamps written.
    pub(super) stamps: u32,
    /// Name of the step before.
    pub(super) before: Option<u32>,
}

impl Stopwatch<'_> {
    /// Before the first and after the last step.
    pub(super) fn stamp(&mut self, recorder: &Recorder<'_>) {
        recorder.timestamp(self.timestamps, self.stamps);
        self.stamps += 1;
    }

    /// Before the step `row`.
    pub(super) fn step(&mut self, recorder: &Recorder<'_>, row: u32, name: u32) {
        let before = self.before.replace(name);
        let timed = |name| self.plan.times(self.turns, name);
        let (timed_before, timed) = (before.is_some_and(timed), timed(name));
        let splits = before != Some(name) || self.plan == Plan::Full;
        if splits && before.is_some() && (timed_before || timed) {
            self.stamp(recorder);
        }
        match self.intervals.last_mut() {
            Some(interval) if timed && !splits => interval.steps += 1,
            _ if timed => self.intervals.push(Interval {
                row,
                steps: 1,
                stamp: self.stamps.saturating_sub(1),
            }),
            _ => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// project (0), compact (1), relax (2) in six rounds, then smooth (3) seven times, scatter (4).
    fn march() -> Vec<u32> {
        let mut steps = [0, 1, 2].repeat(6);
        steps.extend([3; 7]);
        steps.push(4);
        steps
    }

    #[test]
    fn neighbours_share_a_timestamp_and_runs_have_two() {
        let steps = march();
        assert_eq!(stamps(&steps, 3..4), 2);
        assert_eq!(stamps(&steps, 3..5), 2, "the last ends with the frame");
        assert_eq!(stamps(&steps, 0..1), 11, "the first begins with the frame");
        assert_eq!(stamps(&steps, 0..5), 19);
    }

    #[test]
    fn every_name_has_its_turn_and_turns_cost_what_they_may_on_average() {
        for steps in [march(), vec![], vec![0], vec![0; 9], (0..40).collect()] {
            let turns = Turns::new(&steps);
            assert!(turns.of.iter().all(|turn| *turn < turns.count));
            let names = steps.iter().max().map_or(0, |last| last + 1);
            assert_eq!(turns.of.len(), names as usize);
            let stamps = |turn: &u32| {
                let times = |name: &u32| turns.of[*name as usize] == *turn;
                let ends = steps
                    .windows(2)
                    .filter(|p| p[0] != p[1] && p.iter().any(times));
                ends.count() as u32
            };
            let sum: u32 = (0..turns.count).map(|turn| stamps(&turn)).sum();
            assert!(sum <= STAMPS * turns.count, "{turns:?}");
        }
    }

    #[test]
    fn names_that_need_many_timestamps_are_alone_and_rest_afterwards() {
        let turns = Turns::new(&march());
        assert_eq!(turns.of, [0, 3, 6, 9, 9]);
        assert_eq!(turns.count, 10);
    }
}
