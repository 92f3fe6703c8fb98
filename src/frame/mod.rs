//! A frame as data: an ordered list of passes; derives barriers, adds labels and timestamps, records.
//!
//! [`FrameBuilder`] collects steps (passes, fills, copies) with their resources. The built [`Frame`] is submitted again
//! and again, two submissions in flight: every submission records its command buffer in one walk over the steps, with
//! the barriers that the declared accesses call for. Runs of steps that are the same in every frame can be recorded once
//! ([`FrameBuilder::fix`]); the walk then executes them. After the first submissions nothing is allocated or compiled.

mod build;
mod builder;
mod ceiling;
mod fixed;
mod hazard;
mod hosted;
mod profile;
mod program;
mod replay;
mod stamp;
mod timings;
mod walk;

use std::{ffi::CString, ops::Range, time::Instant};

pub use crate::gpu::{Profile, Slot};
pub use builder::{End, FrameBuilder, PassBuilder};
pub use ceiling::CeilingMeter;
pub use replay::{LEAST_PLACES, ReplayMeter};
pub use stamp::StampMeter;

use builder::Resource;
use fixed::Fixed;
use hazard::Hazards;
use profile::{Interval, Plan, Stopwatch, Turns};
use program::{Command, Dispatch, Extent, Program, Reach};
use timings::Stamps;
use walk::Walk;

use crate::{
    Error, Result,
    gpu::{Commands, Descriptors, FRAMES_IN_FLIGHT, Gpu, Secondaries, Timestamps},
};

/// A run of steps in a submission.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Span {
    /// Rows of the steps.
    pub steps: Range<usize>,
    /// What passes with [`PassBuilder::index_at`] find in their push constants: number of the sub-step, say.
    pub index: u32,
}

/// A checked list of steps with everything that submitting it needs.
pub struct Frame {
    name: String,
    label: CString,
    program: Program,
    /// What is executed rather than recorded anew.
    fixed: Vec<Fixed>,
    /// Names of steps, in order of first appearance.
    names: Vec<String>,
    all: [Span; 1],
    hazards: Hazards,
    slots: [SlotState; FRAMES_IN_FLIGHT],
    next: usize,
    begun: Option<Slot>,
    /// None for the device's.
    profile: Option<Profile>,
    turns: Turns,
    /// Of the next submission that is sampled.
    turn: u32,
    harvest: Stamps,
    /// Kept alive for [`Frame::fixed`].
    _secondaries: Option<Secondaries>,
    _descriptors: Option<Descriptors>,
    /// Kept alive for the descriptor sets.
    resources: Vec<Resource>,
    gpu: Gpu,
}

/// What one of the frames in flight has for itself.
struct SlotState {
    commands: Commands,
    timestamps: Option<Timestamps>,
    /// What stands between the timestamps written last.
    intervals: Vec<Interval>,
    /// Timestamps written; 0 where the submission was not timed.
    stamps: u32,
    /// See [`crate::report::FrameTimings::turns`].
    turns: u32,
    submission: u64,
    cpu_record_ns: u64,
}

impl SlotState {
    fn new(commands: Commands, steps: usize) -> Result<Self> {
        Ok(Self {
            commands,
            timestamps: None,
            intervals: Vec::with_capacity(steps),
            stamps: 0,
            turns: 1,
            submission: 0,
            cpu_record_ns: 0,
        })
    }
}

impl Frame {
    /// Waits until the next slot is free, so that its ring buffers may be written.
    ///
    /// # Errors
    /// [`Error::Vulkan`] where the device was lost.
    pub fn begin(&mut self) -> Result<Slot> {
        if let Some(slot) = self.begun {
            return Ok(slot);
        }
        let slot = self.next;
        self.wait_for(self.slots[slot].submission)?;
        self.harvest.take(&self.slots[slot]);
        self.begun = Some(Slot(slot));
        Ok(Slot(slot))
    }

    /// Records all steps in order and submits them; does not wait.
    ///
    /// # Errors
    /// [`Error::Vulkan`] where recording or submitting fails.
    pub fn submit(&mut self) -> Result<()> {
        let all = std::mem::replace(
            &mut self.all,
            [Span {
                steps: 0..0,
                index: 0,
            }],
        );
        let submitted = self.submit_spans(&all);
        self.all = all;
        submitted
    }

    /// Records runs of steps, some perhaps several times or not at all, and submits them; does not wait.
    ///
    /// # Errors
    /// [`Error::Argument`] for steps that do not exist; [`Error::Vulkan`] where recording or submitting fails.
    pub fn submit_spans(&mut self, spans: &[Span]) -> Result<()> {
        let slot = self.begin()?;
        let count = self.count(spans)?;
        let plan = Plan::new(self.profile(), self.turn);
        self.prepare_timestamps(slot, plan, count)?;
        let before = Instant::now();
        self.slots[slot.0].stamps = 0;
        let stamps = self.record(slot, spans, plan)?;
        let state = &mut self.slots[slot.0];
        state.cpu_record_ns = before.elapsed().as_nanos() as u64;
        state.submission = state.commands.submit(&self.name)?;
        state.stamps = stamps;
        state.turns = 1;
        if matches!(plan, Some(Plan::Turn(_))) {
            state.turns = self.turns.count;
            self.turn = (self.turn + 1) % self.turns.count;
        }
        (self.begun, self.next) = (None, (slot.0 + 1) % FRAMES_IN_FLIGHT);
        Ok(())
    }

    /// Waits for all submissions of this frame.
    ///
    /// # Errors
    /// [`Error::Vulkan`] where the device was lost.
    pub fn wait(&mut self) -> Result<()> {
        let newest = self.slots.iter().map(|s| s.submission).max();
        self.wait_for(newest.unwrap_or(0))?;
        self.gpu.shared.collect();
        Ok(())
    }

    /// Submits and waits, for work that is done once.
    ///
    /// # Errors
    /// As [`Frame::submit`] and [`Frame::wait`].
    pub fn run(&mut self) -> Result<()> {
        self.submit()?;
        self.wait()
    }

    /// Nanoseconds that recording the last submission took on the CPU; needs no profile.
    pub fn cpu_record_ns(&self) -> u64 {
        let newest = self.slots.iter().max_by_key(|s| s.submission);
        newest.map_or(0, |s| s.cpu_record_ns)
    }

    /// Changes how this frame is timed from the next submission on, whatever the device's profile is; without effect
    /// where the device has no timestamps.
    pub fn set_profile(&mut self, profile: Profile) {
        self.profile = Some(profile);
    }

    fn profile(&self) -> Profile {
        if self.gpu.features().timestamps {
            let shared = || self.gpu.shared.profile.get();
            self.profile.unwrap_or_else(shared)
        } else {
            Profile::Off
        }
    }

    /// Changes the push constants of a step from the next submission on.
    ///
    /// # Errors
    /// [`Error::Argument`] where the step is no pass, is fixed ([`FrameBuilder::fix`]) or has another number of bytes.
    pub fn set_constants<T: bytemuck::NoUninit>(
        &mut self,
        step: usize,
        constants: &T,
    ) -> Result<()> {
        let bytes = bytemuck::bytes_of(constants);
        let range = self.dispatch(step)?.constants();
        if bytes.len() != range.len() {
            let reason = format!(
                "{} bytes of push constants, not {}",
                range.len(),
                bytes.len()
            );
            return Err(Error::argument(format!("step {step}"), reason));
        }
        self.program.constants[range].copy_from_slice(bytes);
        Ok(())
    }

    /// Changes the number of items of a step from the next submission on.
    ///
    /// # Errors
    /// [`Error::Argument`] where the step is no pass or is fixed; [`Error::Pass`] for more workgroups than the device has.
    pub fn set_items(&mut self, step: usize, items: u32) -> Result<()> {
        let declaration = self.dispatch(step)?.pipeline.declaration;
        let groups = [items.div_ceil(declaration.local_size[0].max(1)), 1, 1];
        build::check_groups(&self.gpu, declaration.name, groups)?;
        self.dispatch(step)?.extent = Extent::Groups(groups);
        Ok(())
    }

    fn dispatch(&mut self, step: usize) -> Result<&mut Dispatch> {
        let is_fixed = self.fixed.iter().any(|run| run.steps.contains(&step));
        match self.program.steps.get_mut(step).map(|s| &mut s.command) {
            Some(Command::Dispatch(dispatch)) if !is_fixed => Ok(dispatch),
            _ => Err(Error::argument(
                format!("step {step}"),
                format!("no pass of frame {} that may change", self.name),
            )),
        }
    }

    fn wait_for(&self, submission: u64) -> Result<()> {
        let shared = &self.gpu.shared;
        shared.queue.wait(&shared.device, submission, &self.name)
    }

    fn count(&self, spans: &[Span]) -> Result<u32> {
        let wrong = spans
            .iter()
            .find(|s| s.steps.end > self.program.steps.len());
        if let Some(span) = wrong {
            let reason = format!("steps {:?} of {}", span.steps, self.program.steps.len());
            return Err(Error::argument(
                format!("span of frame {}", self.name),
                reason,
            ));
        }
        for span in spans {
            self.check_copies(span)?;
        }
        Ok(spans.iter().map(|s| s.steps.len() as u32).sum())
    }

    /// Slices that a span's copies reach are within their buffers.
    fn check_copies(&self, span: &Span) -> Result<()> {
        let beyond = |reach: &&Reach| span.steps.contains(&reach.step) && span.index > reach.last;
        match self.program.reaches.iter().find(beyond) {
            Some(reach) => {
                let reason = format!("slice {} passes its end", span.index);
                let name = self.resources[reach.resource].name();
                Err(Error::argument(name, reason))
            }
            None => Ok(()),
        }
    }

    /// Makes room for timestamps before, between and after `count` steps; allocates only when there are more steps than
    /// ever before.
    fn prepare_timestamps(&mut self, slot: Slot, plan: Option<Plan>, count: u32) -> Result<()> {
        let state = &mut self.slots[slot.0];
        let room = state.timestamps.as_ref().map_or(0, |t| t.capacity);
        if plan.is_some() && room < count + 3 {
            state.timestamps = Some(Timestamps::new(&self.gpu.shared, &self.name, count + 3)?);
        }
        Ok(())
    }

    /// The number of timestamps written.
    fn record(&mut self, slot: Slot, spans: &[Span], plan: Option<Plan>) -> Result<u32> {
        let Self {
            slots,
            program,
            fixed,
            hazards,
            turns,
            ..
        } = self;
        let state = &mut slots[slot.0];
        let recorder = state.commands.begin(&self.name)?;
        let mut walk = Walk::new(&recorder, program, hazards, slot);
        match plan.zip(state.timestamps.as_ref()) {
            Some((plan, timestamps)) => {
                state.intervals.clear();
                recorder.reset(timestamps);
                walk.watch = Some(Stopwatch {
                    plan,
                    turns,
                    timestamps,
                    intervals: &mut state.intervals,
                    stamps: 0,
                    before: None,
                });
            }
            None => walk.fixed = fixed,
        }
        let stamps = walk.frame(&self.label, spans);
        recorder.end(&self.name)?;
        Ok(stamps)
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests;
