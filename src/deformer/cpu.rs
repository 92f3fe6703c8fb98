//! The CPU device: the twins of all passes, run in order over plain buffers.

use bytemuck::{Pod, cast_slice, cast_slice_mut};

use super::{
    Kind, Resource,
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

/// All buffers and images of a deformer on the CPU, whose instances run one after the other.
#[derive(Debug, Default)]
pub(crate) struct Store {
    /// What the instances share, a row a [`Resource`].
    shared: Vec<Vec<u32>>,
    /// What every instance has for itself, a row a [`Resource`].
    own: Vec<Vec<Vec<u32>>>,
    /// The instance that runs.
    pub(super) instance: usize,
    pub(crate) atlas: Image,
    pub(crate) operators: Image,
}

impl Store {
    pub(super) fn new(statics: &Statics, instances: usize, atlas: Image, operators: Image) -> Self {
        let content = |r: Resource| {
            let mut words = statics
                .content
                .get(&(r as u32))
                .cloned()
                .unwrap_or_default();
            let size = statics.words.get(&(r as u32)).copied().unwrap_or(0);
            words.resize(words.len().max(size), 0);
            words
        };
        let buffers = |own: bool| -> Vec<Vec<u32>> {
            let content = |r: &Resource| match is_own(*r) == own {
                true => content(*r),
                false => Vec::new(),
            };
            Resource::ALL.iter().map(content).collect()
        };
        Self {
            shared: buffers(false),
            own: vec![buffers(true); instances],
            instance: 0,
            atlas,
            operators,
        }
    }

    /// Content of a buffer, the running instance's.
    pub(crate) fn read<T: Pod>(&self, resource: Resource) -> &[T] {
        cast(self.buffer(resource))
    }

    pub(super) fn instances(&self) -> usize {
        self.own.len()
    }

    fn buffer(&self, resource: Resource) -> &Vec<u32> {
        let own = is_own(resource);
        let buffers = if own {
            &self.own[self.instance]
        } else {
            &self.shared
        };
        &buffers[resource as usize]
    }

    fn buffer_mut(&mut self, resource: Resource) -> &mut Vec<u32> {
        let own = is_own(resource);
        let buffers = if own {
            &mut self.own[self.instance]
        } else {
            &mut self.shared
        };
        &mut buffers[resource as usize]
    }

    /// Replaces the beginning of a buffer, growing it where it is shorter.
    pub(crate) fn write<T: Pod>(&mut self, resource: Resource, content: &[T]) {
        let words: &[u8] = cast_slice(content);
        let buffer = self.buffer_mut(resource);
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
                _ if is_own(r) => self.own.iter().map(|own| own[r as usize].len() * 4).sum(),
                _ => self.shared[r as usize].len() * 4,
            };
            (r.label(), r.class().name(), bytes as u64)
        }))
    }

    /// Runs the steps in order for the chosen instance, as those of a slice.
    pub(crate) fn run(&mut self, steps: &[Step], slice: usize) {
        for step in steps {
            self.step(step, slice);
        }
    }

    fn step(&mut self, step: &Step, slice: usize) {
        match step {
            Step::Take(ring, to) => {
                let count = self.buffer(*to).len();
                let first = (slice * self.instances() + self.instance) * count;
                let words = self.buffer(*ring)[first..first + count].to_vec();
                *self.buffer_mut(*to) = words;
            }
            Step::Keep(from, to) => {
                let words = self.buffer(*from).clone();
                let first = slice * words.len();
                self.buffer_mut(*to)[first..first + words.len()].copy_from_slice(&words);
            }
            Step::Clear(resource) => self.buffer_mut(*resource).fill(0),
            Step::Empty(row) => {
                let heads = self.buffer_mut(Resource::Dispatches);
                heads[*row as usize * size_of::<Dispatch>() / 4] = 0;
            }
            Step::Copy(from, to) => {
                let source = std::mem::take(self.buffer_mut(*from));
                self.buffer_mut(*to).copy_from_slice(&source);
                *self.buffer_mut(*from) = source;
            }
            Step::Dispatch {
                pass,
                bind,
                constants,
                slice_at,
                extent,
                variant,
            } => {
                if let Extent::Indirect(row) = extent
                    && self.read::<Dispatch>(Resource::Dispatches)[*row as usize].groups[0] == 0
                {
                    return;
                }
                let mut constants = constants.clone();
                if let Some(byte) = *slice_at {
                    constants[byte..byte + 4].copy_from_slice(&(slice as u32).to_ne_bytes());
                }
                self.dispatch(pass, bind, &constants, *variant);
            }
        }
    }

    fn dispatch(&mut self, pass: &Pass, bind: &[Resource], constants: &[u8], variant: u32) {
        let bindings = pass.declaration.bindings;
        // Written buffers leave the store while the twin runs, so that the others can be borrowed.
        let writes = |i: usize| bindings[i].access.writes();
        let mut taken: Vec<Option<Vec<u32>>> = (0..bind.len())
            .map(|i| writes(i).then(|| std::mem::take(self.buffer_mut(bind[i]))))
            .collect();
        let slots = taken
            .iter_mut()
            .zip(bind)
            .zip(bindings)
            .map(
                |((taken, resource), binding)| match (taken, binding.access) {
                    (Some(words), _) => Slot::Write(words),
                    (None, Access::Sampled) => Slot::Image(self.image(*resource)),
                    (None, _) => Slot::Read(self.buffer(*resource)),
                },
            );
        (pass.twin)(&mut Args::new(slots.collect(), constants).with_variant(variant));
        for (words, resource) in taken.into_iter().zip(bind) {
            if let Some(words) = words {
                *self.buffer_mut(*resource) = words;
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

/// Every instance has one for itself.
fn is_own(resource: Resource) -> bool {
    resource.kind() == Kind::Transient
}
