//! Real characters and a device for the integration tests.
#![allow(clippy::unwrap_used, dead_code, unreachable_pub)]

use std::path::{Path, PathBuf};

use dermis::{
    asset::{self, Model},
    gpu::{Gpu, GpuOptions},
};

/// Characters that take a second or less to prepare.
pub const CHARACTERS: [&str; 5] = [
    "khronos/CesiumMan.glb",
    "khronos/Fox.glb",
    "khronos/RiggedFigure.glb",
    "mesh2motion/horse-animations.glb",
    "mesh2motion/human-male.glb",
];

/// The [`CHARACTERS`] of the shared data; none, and a line that says so, where the folder does not exist.
pub fn characters() -> impl Iterator<Item = (&'static str, Model)> {
    let data = data();
    let names = data.as_ref().map_or(&[][..], |_| &CHARACTERS);
    let root = data.unwrap_or_default().join("characters");
    names
        .iter()
        .map(move |name| (*name, asset::load(&root.join(name)).unwrap()))
}

/// The folder of the shared data; none, and a line that says so, where it does not exist.
pub fn data() -> Option<PathBuf> {
    let data = std::env::var_os("DERMIS_DATA").map_or_else(
        || Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/data"),
        PathBuf::from,
    );
    let there = data.is_dir();
    if !there {
        eprintln!("skipped: no data at {} (DERMIS_DATA)", data.display());
    }
    there.then_some(data)
}

/// A device with validation; `None` where `DERMIS_NO_GPU=1` asks for the skip.
pub fn gpu() -> Option<Gpu> {
    if std::env::var("DERMIS_NO_GPU").is_ok_and(|v| v == "1") {
        eprintln!("skipped: DERMIS_NO_GPU=1");
        return None;
    }
    let options = GpuOptions {
        validation: true,
        ..GpuOptions::default()
    };
    let gpu = Gpu::new(&options).unwrap();
    eprintln!("{}", gpu.report().name);
    Some(gpu)
}
