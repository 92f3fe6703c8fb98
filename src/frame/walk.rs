//! The walk over the steps of a frame that records them, with the barriers between them.

use std::{ffi::CString, ops::Range};

use super::{
    Span,
    fixed::Fixed,
    hazard::{Barrier, Hazards, Uses},
    profile::Stopwatch,
    program::Program,
};
use crate::gpu::{Recorder, Scope, Slot};

/// A walk over steps that records them.
pub(super) struct Walk<'a> {
    pub(super) recorder: &'a Recorder<'a>,
    pub(super) program: &'a Program,
    pub(super) hazards: &'a mut Hazards,
    pub(super) slot: Slot,
    /// What is executed rather than recorded anew.
    pub(super) fixed: &'a [Fixed],
    pub(super) watch: Option<Stopwatch<'a>>,
    /// Fixed steps came last.
    after_fixed: bool,
    /// How steps so far wrote what the CPU may look at.
    mapped: Uses,
}

impl<'a> Walk<'a> {
    /// Begins after a barrier between all before and all that is recorded.
    pub(super) fn new(
        recorder: &'a Recorder<'a>,
        program: &'a Program,
        hazards: &'a mut Hazards,
        slot: Slot,
    ) -> Self {
        hazards.clear();
        Self {
            recorder,
            program,
            hazards,
            slot,
            fixed: &[],
            watch: None,
            after_fixed: false,
            mapped: Uses::default(),
        }
    }

    /// Records a frame; gives the number of timestamps written.
    pub(super) fn frame(mut self, label: &CString, spans: &[Span]) -> u32 {
        self.recorder.begin_label(label);
        // The frame before may still run, and whatever it did comes first.
        self.recorder.barrier(Scope::ALL, Scope::ALL);
        self.stamp();
        for span in spans {
            self.steps(span.steps.clone(), span.index);
        }
        // The second tells what one costs.
        self.stamp();
        self.stamp();
        if !self.mapped.is_empty() {
            self.recorder.barrier(self.mapped.scope(), Scope::HOST);
        }
        self.recorder.end_label();
        self.watch.map_or(0, |watch| watch.stamps)
    }

    /// Records steps.
    pub(super) fn steps(&mut self, steps: Range<usize>, index: u32) {
        let mut row = steps.start;
        while row < steps.end {
            let mut runs = self.fixed.iter();
            match runs.find(|run| run.steps.start == row && run.steps.end <= steps.end) {
                Some(run) => {
                    self.run(run);
                    row = run.steps.end;
                }
                None => {
                    self.step(row, index);
                    row += 1;
                }
            }
        }
    }

    /// Begins with a barrier of its own.
    fn run(&mut self, run: &Fixed) {
        self.recorder.execute(run.commands);
        self.mapped = self.mapped.with(run.mapped);
        self.after_fixed = true;
    }

    fn step(&mut self, row: usize, index: u32) {
        if std::mem::take(&mut self.after_fixed) {
            self.barrier(Barrier::ALL);
            self.hazards.clear();
        }
        let (recorder, program) = (self.recorder, self.program);
        let step = &program.steps[row];
        if let Some(watch) = &mut self.watch {
            watch.step(recorder, row as u32, step.name_row);
        }
        recorder.begin_label(&step.label);
        if let Some(barrier) = self.hazards.step(program.uses(step)) {
            self.barrier(barrier);
        }
        let (constants, slot) = (&program.constants, self.slot.0);
        step.command.record(recorder, constants, slot, index);
        recorder.end_label();
        self.mapped = self.mapped.with(step.mapped);
    }

    pub(super) fn barrier(&self, barrier: Barrier) {
        let (from, to) = barrier.scopes();
        self.recorder.barrier(from, to);
    }

    fn stamp(&mut self) {
        if let Some(watch) = &mut self.watch {
            watch.stamp(self.recorder);
        }
    }
}
