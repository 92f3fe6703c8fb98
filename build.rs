//! Refuses to build with SPIR-V that is older than its shader.

#[allow(dead_code)]
#[path = "shaders/sources.rs"]
mod sources;

use std::{path::Path, process::exit};

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rerun-if-changed=shaders");
    let problem = match sources::stale(Path::new("shaders")) {
        Ok(None) => return,
        Ok(Some(problem)) | Err(problem) => problem,
    };
    println!("cargo::error={problem}");
    exit(1);
}
