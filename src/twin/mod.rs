//! One file a GPU pass, same name: the same computation on the CPU, plain and obvious.

mod ceiling_copy;
mod ceiling_fetch;
pub mod field_grid;

pub use ceiling_copy::ceiling_copy;
pub use ceiling_fetch::ceiling_fetch;
