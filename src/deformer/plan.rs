//! A frame of each method as data: the steps that both the GPU and the CPU device walk.

mod implicit;
mod steps;
mod tracking;

use std::ops::Range;

pub(super) use tracking::{ROUND, STRIDE, rows};

use super::{Method, Resource, Settings};
use crate::{gpu::Declaration, twin};

/// A pass: its declaration for the GPU and its twin for the CPU.
#[derive(Clone, Copy, Debug)]
pub struct Pass {
    /// For the GPU.
    pub declaration: &'static Declaration,
    /// For the CPU.
    pub twin: fn(&mut twin::Args<'_>),
}

/// How many workgroups a step runs for an instance.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Extent {
    /// One invocation an item.
    Items(u32),
    /// Workgroups.
    Groups([u32; 3]),
    /// As many as a row of [`Resource::Dispatches`] says.
    Indirect(u32),
}

/// One step of a frame.
#[derive(Clone, Debug)]
pub enum Step {
    /// A dispatch.
    Dispatch {
        /// What runs.
        pass: Pass,
        /// A resource a binding.
        bind: Vec<Resource>,
        /// Specialization constant 0.
        variant: u32,
        /// Push constants.
        constants: Vec<u8>,
        /// Byte of the push constants where the number of the slice stands.
        slice_at: Option<usize>,
        /// How often.
        extent: Extent,
    },
    /// Sets every word of a buffer to 0.
    Clear(Resource),
    /// Lets a row of [`Resource::Dispatches`] have no workgroups, before the lists of several instances say how many.
    Empty(u32),
    /// Copies a whole buffer.
    Copy(Resource, Resource),
    /// Fills a buffer with the sub-step's slice of a ring.
    Take(Resource, Resource),
    /// Copies a whole buffer into the sub-step's slice of another.
    Keep(Resource, Resource),
}

/// The steps of a frame in sections, of which some run more than once.
#[derive(Clone, Debug, Default)]
pub(super) struct Plan {
    /// All steps.
    pub(super) steps: Vec<Step>,
    /// Run once, before all sub-steps.
    pub(super) before: Range<usize>,
    /// Begin of a sub-step.
    pub(super) begin: Range<usize>,
    /// A round of a sub-step that another follows.
    pub(super) round: Range<usize>,
    /// The last round of a sub-step.
    pub(super) last_round: Range<usize>,
    /// Looks for faults after a large sub-step, which is then done again in halves if there are any.
    pub(super) judge: Range<usize>,
    /// Begin of a half; does nothing to a skin without faults.
    pub(super) half: Range<usize>,
    /// End of a sub-step or of a half.
    pub(super) end: Range<usize>,
    /// Run once, after all sub-steps.
    pub(super) after: Range<usize>,
}

/// Steps to run in a row, with what they take for the number of their slice.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Run {
    pub(super) steps: Range<usize>,
    pub(super) slice: u32,
}

impl Plan {
    /// A plan whose steps are all the begin of its only sub-step.
    fn once(steps: Vec<Step>) -> Self {
        Self::of([
            vec![],
            steps,
            vec![],
            vec![],
            vec![],
            vec![],
            vec![],
            vec![],
        ])
    }

    /// Sections in the order of the fields.
    fn of(sections: [Vec<Step>; 8]) -> Self {
        let mut at = 0;
        let [before, begin, round, last_round, judge, half, end, after] =
            std::array::from_fn(|i| {
                let section = at..at + sections[i].len();
                at = section.end;
                section
            });
        Self {
            steps: sections.concat(),
            before,
            begin,
            round,
            last_round,
            judge,
            half,
            end,
            after,
        }
    }

    /// The rows of every section.
    pub(super) fn sections(&self) -> [Range<usize>; 8] {
        let sections = [
            &self.before,
            &self.begin,
            &self.round,
            &self.last_round,
            &self.judge,
            &self.half,
            &self.end,
            &self.after,
        ];
        sections.map(Range::clone)
    }

    /// The order of the frame with these sub-steps. Slices of poses are counted over sub-steps and their halves, those of a
    /// round over all rounds.
    pub(super) fn for_each_run(&self, substeps: &[Substep], mut each: impl FnMut(Run)) {
        each(run(&self.before, 0));
        let (mut slice, mut round) = (0, 0);
        for substep in substeps {
            for part in 0..substep.slices() {
                let begin = if part == 0 { &self.begin } else { &self.half };
                each(run(begin, slice));
                slice += 1;
                let rounds = round..round + substep.rounds;
                round = rounds.end;
                for k in rounds {
                    let last = k + 1 == round;
                    each(run(if last { &self.last_round } else { &self.round }, k));
                }
                if part == 0 && substep.halves {
                    each(run(&self.judge, 0));
                } else {
                    each(run(&self.end, 0));
                }
            }
        }
        each(run(&self.after, 0));
    }
}

fn run(steps: &Range<usize>, slice: u32) -> Run {
    Run {
        steps: steps.clone(),
        slice,
    }
}

/// A sub-step of a frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Substep {
    /// Rounds of iterations, of a half as well.
    pub(super) rounds: u32,
    /// It is done again in halves where it leaves faults.
    pub(super) halves: bool,
}

impl Substep {
    /// Slices of poses: of the whole, and of its halves.
    pub(super) fn slices(self) -> u32 {
        if self.halves { 3 } else { 1 }
    }
}

/// Sizes of a rig as a plan needs them.
#[derive(Clone, Copy, Debug, Default)]
pub struct Sizes {
    /// Welded vertices.
    pub vertices: u32,
    /// Rows of the file.
    pub rows: u32,
    /// Joints.
    pub joints: u32,
    /// Influences a vertex.
    pub width: u32,
    /// Fields.
    pub fields: u32,
    /// Rows of the file that follow a spine.
    pub fleshed: u32,
    /// How the shaders compose fields ([`crate::layout::composition`]).
    pub composition: u32,
    /// Instances that share a buffer, each with a part of its own.
    pub instances: u32,
}

impl Sizes {
    /// Fields that an instance's part of the posed fields has room for.
    pub fn field_room(&self) -> u32 {
        self.fields.max(1)
    }
}

/// Rows of [`Resource::Dispatches`].
pub(super) fn dispatch_rows(settings: &Settings) -> u32 {
    match settings.method {
        // The seeds, a row a round, contacts, the region around them.
        Method::Implicit => settings.rounds + 3,
        Method::Tracking => tracking::rows::COUNT,
        Method::Lbs | Method::Dqs => 1,
    }
}

/// The steps of one frame.
pub(super) fn frame(sizes: &Sizes, settings: &Settings) -> Plan {
    let pose = [steps::take_palette(), steps::take_fields()];
    let skin = |linear| {
        let mut steps = vec![steps::take_palette(), steps::skin_file_rows(sizes, linear)];
        steps.extend(steps::flesh(sizes));
        Plan::once(steps)
    };
    match settings.method {
        Method::Lbs => skin(true),
        Method::Dqs => skin(false),
        Method::Implicit => Plan::once([&pose[..], &implicit::frame(sizes, settings)].concat()),
        Method::Tracking => tracking::frame(sizes, settings),
    }
}

/// The steps that measure the iso-values of whatever [`Resource::Positions`] holds.
pub(super) fn measure_iso(sizes: &Sizes) -> Vec<Step> {
    let pose = [steps::take_palette(), steps::take_fields()];
    [&pose[..], &steps::index(sizes), &[steps::measure(sizes)]].concat()
}
