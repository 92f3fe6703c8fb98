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

/// How many workgroups a step runs.
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
        /// How often.
        extent: Extent,
    },
    /// Sets every word of a buffer to 0.
    Clear(Resource),
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
    /// A round of a sub-step.
    pub(super) round: Range<usize>,
    /// End of a sub-step.
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
        Self::of([vec![], steps, vec![], vec![], vec![]])
    }

    /// Sections in the order of the fields.
    fn of(sections: [Vec<Step>; 5]) -> Self {
        let mut at = 0;
        let [before, begin, round, end, after] = [0, 1, 2, 3, 4].map(|i| {
            let section = at..at + sections[i].len();
            at = section.end;
            section
        });
        Self {
            steps: sections.concat(),
            before,
            begin,
            round,
            end,
            after,
        }
    }

    /// The order of the frame whose sub-steps have these numbers of rounds. Slices of a sub-step are counted over the
    /// sub-steps, those of a round over all rounds.
    pub(super) fn runs(&self, rounds: &[u32]) -> Vec<Run> {
        let run = |steps: &Range<usize>, slice: usize| Run {
            steps: steps.clone(),
            slice: slice as u32,
        };
        let mut runs = vec![run(&self.before, 0)];
        let mut done = 0;
        for (substep, &rounds) in rounds.iter().enumerate() {
            runs.push(run(&self.begin, substep));
            let all = done..done + rounds as usize;
            done = all.end;
            runs.extend(all.map(|k| run(&self.round, k)));
            runs.push(run(&self.end, substep));
        }
        runs.push(run(&self.after, 0));
        runs
    }
}

/// Sizes of a rig as a plan needs them.
#[derive(Clone, Copy, Debug, Default)]
pub struct Sizes {
    /// Welded vertices.
    pub vertices: u32,
    /// Rows of the file.
    pub rows: u32,
    /// Influences a vertex.
    pub width: u32,
    /// Fields.
    pub fields: u32,
    /// How the shaders compose fields ([`crate::layout::composition`]).
    pub composition: u32,
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
    let skin = |linear| Plan::once([&pose[..1], &[steps::skin_file_rows(sizes, linear)]].concat());
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
