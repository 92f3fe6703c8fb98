//! One file a GPU pass: what it reads and writes, its constants and extent; binding numbers are rows of the list.

pub mod advance;
pub mod ceiling_copy;
pub mod ceiling_fetch;
pub mod ceiling_replay;
pub mod compact;
pub mod diffuse;
pub mod field_grid;
pub mod goals;
pub mod index;
pub mod judge;
pub mod mark;
pub mod measure;
pub mod moved;
pub mod normals;
pub mod output;
pub mod project;
pub mod redo;
pub mod relax;
pub mod scatter;
pub mod settle;
pub mod skin_dqs;
pub mod skin_lbs;
pub mod slide;
pub mod smooth;
pub mod touch;
pub mod track;
