//! Steps that are the same in every frame, whatever its slot and spans: recorded once, executed by the frames.
//!
//! A command costs the CPU a tenth of a microsecond to record, and several tenths where the caches hold nothing of step and driver. A pass is
//! four commands or five, a run of passes that is executed is one.

use std::ops::Range;

use ash::vk;

use super::{
    Frame,
    builder::Resource,
    hazard::{Barrier, Hazards, Uses},
    program::{Built, Program},
    walk::Walk,
};
use crate::{
    Result,
    gpu::{Secondaries, Slot},
};

/// A run of steps that was recorded.
pub(super) struct Fixed {
    pub(super) steps: Range<usize>,
    pub(super) commands: vk::CommandBuffer,
    /// How they write what the CPU may look at.
    pub(super) mapped: Uses,
}

impl Frame {
    /// Records the steps of these sections that are the same in every frame.
    pub(super) fn fix(&mut self, sections: Vec<Range<usize>>) -> Result<()> {
        let (program, resources) = (&self.program, &self.resources);
        let fixed = |row: &usize| is_fixed(program, &program.steps[*row], resources);
        let runs: Vec<_> = sections.into_iter().flat_map(|s| runs(s, fixed)).collect();
        if runs.is_empty() {
            return Ok(());
        }
        let mut hazards = Hazards::new(resources.len());
        let shared = &self.gpu.shared;
        let commands = Secondaries::new(shared, &self.name, runs.len(), |row, recorder| {
            let mut walk = Walk::new(recorder, program, &mut hazards, Slot(0));
            // What comes before differs from frame to frame.
            walk.barrier(Barrier::ALL);
            walk.steps(runs[row].clone(), 0);
        })?;
        let fixed = runs.into_iter().enumerate().map(|(row, steps)| Fixed {
            commands: commands.raw(row),
            mapped: program.steps[steps.clone()]
                .iter()
                .fold(Uses::default(), |all, step| all.with(step.mapped)),
            steps,
        });
        self.fixed = fixed.collect();
        self._secondaries = Some(commands);
        Ok(())
    }
}

/// Runs of rows that are fixed.
fn runs(section: Range<usize>, fixed: impl Fn(&usize) -> bool) -> Vec<Range<usize>> {
    let rows: Vec<_> = section.filter(fixed).collect();
    let runs = rows.chunk_by(|a, b| a + 1 == *b);
    runs.map(|run| run[0]..run[0] + run.len()).collect()
}

/// Its commands are the same for every slot and index.
fn is_fixed(program: &Program, step: &Built, resources: &[Resource]) -> bool {
    let mut uses = program.uses(step).iter();
    let in_ring = uses.any(|u| matches!(resources[u.0 as usize], Resource::Ring(_)));
    step.command.is_constant() && !in_ring
}
