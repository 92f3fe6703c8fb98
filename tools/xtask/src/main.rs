//! Maintenance tasks of the dermis workspace.
fn main() {}
