//! One file a GPU pass: what it reads and writes, its constants and extent.

pub mod ceiling_copy;
pub mod ceiling_fetch;
pub mod field_grid;
