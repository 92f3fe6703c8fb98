//! Command line of dermis.
fn main() {}
