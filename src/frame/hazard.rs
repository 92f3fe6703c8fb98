//! Barriers derived from what steps do with resources. Plain data: knows neither commands nor handles.

use ash::vk;

use crate::gpu::{Access, Scope};

/// A set of ways to use a resource.
#[derive(Clone, Copy, Default, PartialEq, Eq)]
pub(super) struct Uses(u8);

impl Uses {
    pub(super) const UNIFORM: Self = Self(1);
    pub(super) const SHADER_READ: Self = Self(2);
    pub(super) const SHADER_WRITE: Self = Self(4);
    pub(super) const INDIRECT: Self = Self(8);
    pub(super) const TRANSFER_READ: Self = Self(16);
    pub(super) const TRANSFER_WRITE: Self = Self(32);

    const WRITES: Self = Self(4 | 32);
    const COMPUTE: Self = Self(1 | 2 | 4);
    const TRANSFER: Self = Self(16 | 32);

    pub(super) fn of(access: Access) -> Self {
        match access {
            Access::Read | Access::Texels | Access::Words | Access::Sampled => Self::SHADER_READ,
            Access::Write | Access::ImageWrite => Self::SHADER_WRITE,
            Access::ReadWrite => Self::SHADER_READ.with(Self::SHADER_WRITE),
            Access::Uniform => Self::UNIFORM,
        }
    }

    pub(super) fn with(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }

    /// Those that write.
    pub(super) fn writes(self) -> Self {
        Self(self.0 & Self::WRITES.0)
    }

    pub(super) fn is_empty(self) -> bool {
        self.0 == 0
    }

    fn contains(self, other: Self) -> bool {
        self.0 & other.0 == other.0
    }

    fn meets(self, other: Self) -> bool {
        self.0 & other.0 != 0
    }

    /// All uses of the pipeline stages that these uses belong to.
    fn stages(self) -> Self {
        let stages = [Self::COMPUTE, Self::INDIRECT, Self::TRANSFER];
        let met = stages.into_iter().filter(|s| self.meets(*s));
        met.fold(Self::default(), Self::with)
    }

    /// Vulkan's stages and accesses for these uses.
    pub(super) fn scope(self) -> Scope {
        use vk::{AccessFlags as A, PipelineStageFlags as S};
        let rows = [
            (Self::UNIFORM, S::COMPUTE_SHADER, A::UNIFORM_READ),
            (Self::SHADER_READ, S::COMPUTE_SHADER, A::SHADER_READ),
            (Self::SHADER_WRITE, S::COMPUTE_SHADER, A::SHADER_WRITE),
            (Self::INDIRECT, S::DRAW_INDIRECT, A::INDIRECT_COMMAND_READ),
            (Self::TRANSFER_READ, S::TRANSFER, A::TRANSFER_READ),
            (Self::TRANSFER_WRITE, S::TRANSFER, A::TRANSFER_WRITE),
        ];
        let mut scope = Scope::default();
        for (_, stages, access) in rows.into_iter().filter(|r| self.contains(r.0)) {
            scope.stages |= stages;
            scope.access |= access;
        }
        scope
    }
}

impl std::fmt::Debug for Uses {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let names = [
            "uniform",
            "read",
            "write",
            "indirect",
            "transfer read",
            "transfer write",
        ];
        let named = names
            .iter()
            .enumerate()
            .filter(|(bit, _)| self.0 >> bit & 1 == 1);
        f.debug_set().entries(named.map(|(_, name)| name)).finish()
    }
}

/// Row of a resource, and what a step does with it.
pub(super) type Use = (u32, Uses);

/// A memory barrier over all resources: what `from` did is done and seen before `to` begins.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Barrier {
    pub(super) from: Uses,
    pub(super) to: Uses,
}

impl Barrier {
    /// Between all that steps may do.
    pub(super) const ALL: Self = Self {
        from: Uses(63),
        to: Uses(63),
    };

    /// Vulkan's two sides. Only writes have to be made available; of a read only its stage counts.
    pub(super) fn scopes(self) -> (Scope, Scope) {
        let mut from = self.from.scope();
        from.access = self.from.writes().scope().access;
        (from, self.to.scope())
    }
}

/// Follows all resources through a frame: a row a resource, and what happened to it since its last write. Each column is an array
/// of its own, so that a barrier passes over all rows at once.
#[derive(Debug)]
pub(super) struct Hazards {
    /// The last write.
    write: Vec<Uses>,
    /// Uses that see it.
    visible: Vec<Uses>,
    /// Reads after it.
    reads: Vec<Uses>,
    /// Uses that come after all these reads.
    ordered: Vec<Uses>,
}

impl Hazards {
    pub(super) fn new(resources: usize) -> Self {
        let column = || vec![Uses::default(); resources];
        Self {
            write: column(),
            visible: column(),
            reads: column(),
            ordered: column(),
        }
    }

    /// Forgets everything: all that happened before is waited for.
    pub(super) fn clear(&mut self) {
        for column in [
            &mut self.write,
            &mut self.visible,
            &mut self.reads,
            &mut self.ordered,
        ] {
            column.fill(Uses::default());
        }
    }

    /// The barrier that has to come before a step with these uses (each resource once).
    pub(super) fn step(&mut self, uses: &[Use]) -> Option<Barrier> {
        let mut barrier = Barrier::default();
        for (row, uses) in uses {
            let hazard = self.hazard(*row as usize, *uses);
            barrier.from = barrier.from.with(hazard.from);
            barrier.to = barrier.to.with(hazard.to);
        }
        let needed = !barrier.from.is_empty();
        if needed {
            self.pass(barrier);
        }
        for (row, uses) in uses {
            self.use_for(*row as usize, *uses);
        }
        needed.then_some(barrier)
    }

    /// What has to be waited for, and by what, before these uses.
    fn hazard(&self, row: usize, uses: Uses) -> Barrier {
        let (write, reads) = (self.write[row], self.reads[row]);
        let mut barrier = Barrier::default();
        let writes = uses.writes();
        if !write.is_empty() && !self.visible[row].contains(uses) {
            barrier = Barrier {
                from: write,
                to: uses,
            };
        }
        if !writes.is_empty() && !reads.is_empty() && !self.ordered[row].contains(writes) {
            barrier.from = barrier.from.with(reads);
            barrier.to = barrier.to.with(writes);
        }
        barrier
    }

    fn pass(&mut self, barrier: Barrier) {
        let Barrier { from, to } = barrier;
        for (write, visible) in self.write.iter().zip(&mut self.visible) {
            let seen = !write.is_empty() & from.contains(*write);
            *visible = visible.with(if seen { to } else { Uses::default() });
        }
        let (from, to) = (from.stages(), to.stages());
        for (reads, ordered) in self.reads.iter().zip(&mut self.ordered) {
            let waited = from.contains(*reads);
            *ordered = ordered.with(if waited { to } else { Uses::default() });
        }
    }

    fn use_for(&mut self, row: usize, uses: Uses) {
        self.ordered[row] = Uses::default();
        if uses.writes().is_empty() {
            self.reads[row] = self.reads[row].with(uses);
        } else {
            self.write[row] = uses.writes();
            self.visible[row] = Uses::default();
            self.reads[row] = Uses::default();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const READ: Uses = Uses::SHADER_READ;
    const WRITE: Uses = Uses::SHADER_WRITE;

    /// Barriers of a chain of steps.
    fn derive(steps: &[&[Use]]) -> Vec<Option<Barrier>> {
        let mut hazards = Hazards::new(8);
        steps.iter().map(|s| hazards.step(s)).collect()
    }

    fn barrier(from: Uses, to: Uses) -> Option<Barrier> {
        Some(Barrier { from, to })
    }

    #[test]
    fn read_after_write_waits() {
        let found = derive(&[&[(0, WRITE)], &[(0, READ)]]);
        assert_eq!(found, [None, barrier(WRITE, READ)]);
    }

    #[test]
    fn write_after_write_waits() {
        let found = derive(&[&[(0, WRITE)], &[(0, WRITE)]]);
        assert_eq!(found, [None, barrier(WRITE, WRITE)]);
    }

    #[test]
    fn write_after_read_waits_for_execution_only() {
        let found = derive(&[&[(0, READ)], &[(0, WRITE)]]);
        assert_eq!(found, [None, barrier(READ, WRITE)]);
        let (from, _) = found[1].unwrap_or_default().scopes();
        assert_eq!(from.stages, vk::PipelineStageFlags::COMPUTE_SHADER);
        assert!(from.access.is_empty());
    }

    #[test]
    fn reads_and_other_resources_do_not_wait() {
        let found = derive(&[
            &[(0, READ)],
            &[(0, READ)],
            &[(1, WRITE)],
            &[(2, WRITE), (0, READ)],
        ]);
        assert_eq!(found, [None; 4]);
    }

    #[test]
    fn a_second_read_needs_no_second_barrier_but_another_kind_of_read_does() {
        let found = derive(&[
            &[(0, WRITE)],
            &[(0, READ)],
            &[(0, READ)],
            &[(0, Uses::INDIRECT)],
        ]);
        let expected = [
            None,
            barrier(WRITE, READ),
            None,
            barrier(WRITE, Uses::INDIRECT),
        ];
        assert_eq!(found, expected);
    }

    #[test]
    fn one_barrier_serves_all_resources() {
        let found = derive(&[&[(0, WRITE), (1, WRITE)], &[(0, READ)], &[(1, READ)]]);
        assert_eq!(found, [None, barrier(WRITE, READ), None]);
    }

    #[test]
    fn a_barrier_between_other_stages_does_not_serve() {
        let fill = Uses::TRANSFER_WRITE;
        let found = derive(&[&[(0, WRITE)], &[(1, fill)], &[(1, READ)], &[(0, READ)]]);
        assert_eq!(
            found,
            [None, None, barrier(fill, READ), barrier(WRITE, READ)]
        );
    }

    #[test]
    fn a_read_after_the_barrier_has_to_be_waited_for_again() {
        let found = derive(&[&[(0, WRITE)], &[(0, READ)], &[(0, READ)], &[(0, WRITE)]]);
        assert_eq!(found[2], None);
        assert_eq!(found[3], barrier(WRITE.with(READ), WRITE));
    }

    #[test]
    fn writes_after_reads_in_two_stages_wait_for_both() {
        let copy = Uses::TRANSFER_READ;
        let found = derive(&[&[(0, READ)], &[(0, copy)], &[(0, WRITE)]]);
        assert_eq!(found[2], barrier(READ.with(copy), WRITE));
        let (from, to) = found[2].unwrap_or_default().scopes();
        use vk::PipelineStageFlags as S;
        assert_eq!(
            (from.stages, to.stages),
            (S::COMPUTE_SHADER | S::TRANSFER, S::COMPUTE_SHADER)
        );
    }

    #[test]
    fn read_write_waits_for_both_of_its_sides() {
        let both = READ.with(WRITE);
        let found = derive(&[&[(0, both)], &[(0, both)], &[(0, READ)]]);
        assert_eq!(found, [None, barrier(WRITE, both), barrier(WRITE, READ)]);
    }

    #[test]
    fn clearing_forgets() {
        let mut hazards = Hazards::new(1);
        hazards.step(&[(0, WRITE)]);
        hazards.clear();
        assert_eq!(hazards.step(&[(0, READ)]), None);
    }

    /// Whatever the frame, replaying its barriers against a model of the rules finds no hazard left.
    #[test]
    fn random_frames_have_every_pair_of_conflicting_uses_ordered() {
        let kinds = [
            READ,
            WRITE,
            READ.with(WRITE),
            Uses::UNIFORM,
            Uses::INDIRECT,
            Uses::TRANSFER_READ,
            Uses::TRANSFER_WRITE,
        ];
        let mut seed = 7u64;
        let mut random = |n: usize| {
            seed = seed
                .wrapping_mul(6364136223846793005)
                .wrapping_add(1442695040888963407);
            (seed >> 33) as usize % n
        };
        for _ in 0..300 {
            let mut hazards = Hazards::new(4);
            let steps: Vec<_> = (0..12)
                .map(|_| {
                    let (a, b) = (random(2) as u32, 2 + random(2) as u32);
                    [(a, kinds[random(7)]), (b, kinds[random(7)])]
                })
                .collect();
            let barriers: Vec<_> = steps.iter().map(|s| hazards.step(s)).collect();
            for later in 0..steps.len() {
                for earlier in 0..later {
                    assert!(
                        is_ordered(&steps, &barriers, earlier, later),
                        "{steps:?} {barriers:?}"
                    );
                }
            }
        }
    }

    /// Conflicting uses of two steps have a chain of barriers between them: a direct one, or through conflicting uses of
    /// the same resource in between (which are themselves checked).
    fn is_ordered(
        steps: &[[Use; 2]],
        barriers: &[Option<Barrier>],
        earlier: usize,
        later: usize,
    ) -> bool {
        steps[later].iter().all(|&(resource, uses)| {
            let Some(&(_, before)) = steps[earlier].iter().find(|s| s.0 == resource) else {
                return true;
            };
            if before.writes().is_empty() && uses.writes().is_empty() {
                return true;
            }
            let between = &steps[earlier + 1..later];
            if between
                .iter()
                .flatten()
                .any(|s| s.0 == resource && !s.1.writes().is_empty())
            {
                return true;
            }
            // A write has to be seen by each of the uses, a read to be over before each of the writes.
            let kinds = (0..6).map(|bit| Uses(1 << bit));
            let mut waiting = kinds
                .filter(|k| uses.contains(*k))
                .filter(|k| !before.writes().is_empty() || Uses::WRITES.contains(*k));
            waiting.all(|kind| {
                let serves = |b: &Barrier| match before.writes() {
                    Uses(0) => b.from.stages().contains(before) && b.to.stages().contains(kind),
                    write => b.from.contains(write) && b.to.contains(kind),
                };
                barriers[earlier + 1..=later].iter().flatten().any(serves)
            })
        })
    }
}
