//! The CPU device: the twins of all passes, run in order over plain buffers.

use bytemuck::{Pod, cast_slice, cast_slice_mut};

use super::{
    Resource,
    plan::{Extent, Pass, Step},
    pose::PoseUpload,
    statics::Statics,
};
use crate::{
    gpu::Access,
    layout::Dispatch,
    report::MemoryReport,
    twin::{Args, Image, Slot, cast},
};

/// All buffers and images of a deformer on the CPU.
#[derive(Debug, Default)]
pub(crate) struct Store {
    /// A row a [`Resource`].
    buffers: Vec<Vec<u32>>,
    pub(crate) atlas: Image,
    pub(crate) operators: Image,
}

impl Store {
    pub(super) fn new(statics: &Statics, atlas: Image, operators: Image) -> Self {
        let buffers = Resource::ALL
            .iter()
            .map(|r| {
                let mut words = statics
                    .content
                    .get(&(*r as u32))
                    .cloned()
                    .unwrap_or_default();
                let size = statics.words.get(&(*r as u32)).copied().unwrap_or(0);
                words.resize(words.len().max(size), 0);
                words
            })
            .collect();
        Self {
            buffers,
            atlas,
            operators,
        }
    }

    pub(crate) fn read<T: Pod>(&self, resource: Resource) -> &[T] {
        cast(&self.buffers[resource as usize])
    }

    /// Replaces the beginning of a buffer, growing it where it is shorter.
    pub(crate) fn write<T: Pod>(&mut self, resource: Resource, content: &[T]) {
        let words: &[u8] = cast_slice(content);
        let buffer = &mut self.buffers[resource as usize];
        buffer.resize(buffer.len().max(words.len().div_ceil(4)), 0);
        cast_slice_mut::<u32, u8>(buffer)[..words.len()].copy_from_slice(words);
    }

    /// Uploads a frame's poses.
    pub(super) fn pose(&mut self, upload: &PoseUpload) {
        self.write(Resource::PaletteRing, upload.palette());
        self.write(Resource::FieldsRing, upload.fields());
    }

    /// Bytes by class and name.
    pub(super) fn memory(&self) -> MemoryReport {
        let image = |i: &Image| i.texels.len() * 8;
        MemoryReport::sum(Resource::ALL.iter().map(|&r| {
            let bytes = match r {
                Resource::Atlas => image(&self.atlas),
                Resource::Operators => image(&self.operators),
                _ => self.buffers[r as usize].len() * 4,
            };
            (r.label(), r.class().name(), bytes as u64)
        }))
    }

    /// Runs the steps in order, as those of a sub-step.
    pub(crate) fn run(&mut self, steps: &[Step], substep: usize) {
        for step in steps {
            self.step(step, substep);
        }
    }

    fn step(&mut self, step: &Step, substep: usize) {
        match step {
            Step::Take(ring, to) => {
                let count = self.buffers[*to as usize].len();
                let slice = substep * count..(substep + 1) * count;
                let words = self.buffers[*ring as usize][slice].to_vec();
                self.buffers[*to as usize] = words;
            }
            Step::Keep(from, to) => {
                let words = self.buffers[*from as usize].clone();
                let first = substep * words.len();
                self.buffers[*to as usize][first..first + words.len()].copy_from_slice(&words);
            }
            Step::Clear(resource) => self.buffers[*resource as usize].fill(0),
            Step::Copy(from, to) => {
                let source = std::mem::take(&mut self.buffers[*from as usize]);
                self.buffers[*to as usize].copy_from_slice(&source);
                self.buffers[*from as usize] = source;
            }
            Step::Dispatch {
                pass,
                bind,
                constants,
                extent,
                variant,
            } => {
                if let Extent::Indirect(row) = extent
                    && self.read::<Dispatch>(Resource::Dispatches)[*row as usize].groups[0] == 0
                {
                    return;
                }
                self.dispatch(pass, bind, constants, *variant);
            }
        }
    }

    fn dispatch(&mut self, pass: &Pass, bind: &[Resource], constants: &[u8], variant: u32) {
        let bindings = pass.declaration.bindings;
        // Written buffers leave the store while the twin runs, so that the others can be borrowed.
        let writes = |i: usize| bindings[i].access.writes();
        let mut taken: Vec<Option<Vec<u32>>> = (0..bind.len())
            .map(|i| writes(i).then(|| std::mem::take(&mut self.buffers[bind[i] as usize])))
            .collect();
        let slots = taken
            .iter_mut()
            .zip(bind)
            .zip(bindings)
            .map(
                |((taken, resource), binding)| match (taken, binding.access) {
                    (Some(words), _) => Slot::Write(words),
                    (None, Access::Sampled) => Slot::Image(self.image(*resource)),
                    (None, _) => Slot::Read(&self.buffers[*resource as usize]),
                },
            );
        (pass.twin)(&mut Args::new(slots.collect(), constants).with_variant(variant));
        for (words, resource) in taken.into_iter().zip(bind) {
            if let Some(words) = words {
                self.buffers[*resource as usize] = words;
            }
        }
    }

    fn image(&self, resource: Resource) -> &Image {
        if resource == Resource::Atlas {
            &self.atlas
        } else {
            &self.operators
        }
    }
}
