//! One file a GPU pass, same name: the same computation on the CPU, plain and obvious. Together they are the CPU device.

pub mod advance;
pub mod ceiling_copy;
pub mod ceiling_fetch;
pub mod ceiling_replay;
pub mod compact;
pub mod diffuse;
pub mod ease;
pub mod field_grid;
pub mod flesh;
pub mod goals;
pub mod index;
pub mod judge;
pub mod mark;
pub mod measure;
pub mod moved;
pub mod normals;
pub mod output;
pub mod particles;
pub mod project;
pub mod redo;
pub mod relax;
pub mod scatter;
pub mod settle;
pub mod shared;
pub mod skin_dqs;
pub mod skin_lbs;
pub mod slide;
pub mod smooth;
pub mod touch;
pub mod track;

mod args;

pub use args::{Args, Image};
pub(crate) use args::{Slot, cast};
pub use ceiling_copy::ceiling_copy;
pub use ceiling_fetch::ceiling_fetch;
pub use ceiling_replay::ceiling_replay;
