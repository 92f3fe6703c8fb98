//! The steps of a frame as recording walks them: in few pieces of memory, with handles in place of resources.
//!
//! A frame is recorded after other work, when the caches hold nothing of it, and each pointer that has to be followed is a wait.

use std::{ffi::CString, ops::Range, sync::Arc};

use ash::vk;

use super::hazard::{Use, Uses};
use crate::gpu::{Bound, FRAMES_IN_FLIGHT, PUSH_CONSTANTS, Pipeline, Recorder};

/// All steps.
#[derive(Default)]
pub(super) struct Program {
    pub(super) steps: Vec<Built>,
    /// What the steps do with resources, step after step.
    pub(super) uses: Vec<Use>,
    /// Push constants, step after step.
    pub(super) constants: Vec<u8>,
    /// How far copies may go.
    pub(super) reaches: Vec<Reach>,
}

/// A step ready to be recorded.
pub(super) struct Built {
    pub(super) command: Command,
    /// Its part of [`Program::uses`].
    pub(super) uses: Range<u32>,
    /// How it writes what the CPU may look at.
    pub(super) mapped: Uses,
    /// Number of the name, in order of first appearance.
    pub(super) name_row: u32,
    pub(super) label: CString,
}

pub(super) enum Command {
    Dispatch(Dispatch),
    Fill(Fill<Buffers>),
    Copy(Copy<Buffers>),
}

/// The buffer of each slot.
pub(super) type Buffers = [vk::Buffer; FRAMES_IN_FLIGHT];

pub(super) struct Dispatch {
    pub(super) bound: Bound,
    /// Kept alive, and asked for its sizes.
    pub(super) pipeline: Arc<Pipeline>,
    /// One a slot.
    pub(super) sets: [Option<vk::DescriptorSet>; FRAMES_IN_FLIGHT],
    /// Its part of [`Program::constants`].
    pub(super) constants: Range<u32>,
    /// Byte of the constants where the span's index stands.
    pub(super) index_at: Option<u32>,
    pub(super) extent: Extent<Buffers>,
}

/// How many workgroups a pass has. Of this and what follows, B is the row of a resource first, and then its buffers.
#[derive(Clone, Copy, Debug)]
pub(super) enum Extent<B> {
    Groups([u32; 3]),
    /// Three counts in a buffer at a byte offset.
    Indirect(B, u64),
}

/// Words of a buffer that get a value.
#[derive(Clone, Copy)]
pub(super) struct Fill<B> {
    pub(super) to: B,
    /// Where the first begins, and all of them, in bytes.
    pub(super) offset: u64,
    pub(super) bytes: u64,
    pub(super) value: u32,
}

/// A copy between two buffers.
#[derive(Clone, Copy)]
pub(super) struct Copy<B> {
    pub(super) from: B,
    pub(super) to: B,
    pub(super) bytes: u64,
    /// By how many bytes source and target move on with [`Span::index`](super::Span::index).
    pub(super) strides: [u64; 2],
}

/// How far an end of a copy may go.
pub(super) struct Reach {
    /// Row of the step.
    pub(super) step: usize,
    /// Row of the resource.
    pub(super) resource: usize,
    /// The last [`Span::index`](super::Span::index) within it.
    pub(super) last: u32,
}

impl Program {
    pub(super) fn uses(&self, step: &Built) -> &[Use] {
        &self.uses[step.uses.start as usize..step.uses.end as usize]
    }
}

impl Command {
    /// Records the command itself. `constants` are all of the program.
    pub(super) fn record(
        &self,
        recorder: &Recorder<'_>,
        constants: &[u8],
        slot: usize,
        index: u32,
    ) {
        match self {
            Self::Dispatch(dispatch) => dispatch.record(recorder, constants, slot, index),
            Self::Fill(fill) => {
                recorder.fill((fill.to[slot], fill.offset), fill.bytes, fill.value);
            }
            Self::Copy(copy) => {
                let [a, b] = copy.strides.map(|stride| stride * u64::from(index));
                recorder.copy((copy.from[slot], a), (copy.to[slot], b), copy.bytes);
            }
        }
    }

    /// It takes nothing from [`Span::index`](super::Span::index).
    pub(super) fn is_constant(&self) -> bool {
        match self {
            Self::Dispatch(dispatch) => dispatch.index_at.is_none(),
            Self::Fill(_) => true,
            Self::Copy(copy) => copy.strides == [0, 0],
        }
    }
}

impl Dispatch {
    /// Bytes of [`Program::constants`].
    pub(super) fn constants(&self) -> Range<usize> {
        self.constants.start as usize..self.constants.end as usize
    }

    fn record(&self, recorder: &Recorder<'_>, all: &[u8], slot: usize, index: u32) {
        let mut constants = [0; PUSH_CONSTANTS as usize];
        let constants = &mut constants[..self.constants().len()];
        constants.copy_from_slice(&all[self.constants()]);
        if let Some(byte) = self.index_at {
            constants[byte as usize..][..4].copy_from_slice(&index.to_ne_bytes());
        }
        recorder.bind(self.bound, self.sets[slot], constants);
        match self.extent {
            Extent::Groups(groups) => recorder.dispatch(groups),
            Extent::Indirect(buffers, offset) => {
                recorder.dispatch_indirect(buffers[slot], offset);
            }
        }
    }
}
