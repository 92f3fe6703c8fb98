//! The sequence that a command is given.

use std::path::{Path, PathBuf};

use dermis::{
    Error, Result,
    asset::{self, Model, Room, Sequence},
    rig, sphere_mesh,
};

use crate::parse;

/// A sequence.
#[derive(clap::Args, Clone, Debug)]
pub(super) struct Source {
    /// Folder of meshes, folder with rest.obj and frames.npy, skinned or morphed GLB or glTF, or one mesh.
    #[arg(value_name = "SEQ")]
    pub(super) sequence: PathBuf,
    #[command(flatten)]
    pub(super) clip: ClipOptions,
}

/// How a clip is sampled.
#[derive(clap::Args, Clone, Debug)]
pub(super) struct ClipOptions {
    /// Clip of a GLB, by name or number; the first one otherwise.
    #[arg(long, value_name = "NAME|INDEX")]
    clip: Option<String>,
    /// Frames a second at which a clip is sampled, 0.001 to 10000.
    #[arg(long, value_name = "N", default_value_t = 30.0, value_parser = rate)]
    fps: f32,
}

fn rate(text: &str) -> Result<f32, String> {
    let rate = parse::positive(text)?;
    if (1e-3..=1e4).contains(&rate) {
        return Ok(rate);
    }
    Err("from 0.001 to 10000 a second".into())
}

impl ClipOptions {
    pub(super) fn fps(&self) -> f32 {
        self.fps
    }
}

impl Source {
    /// The files that it may be read from.
    pub(super) fn files(&self) -> Vec<PathBuf> {
        match std::fs::read_dir(&self.sequence) {
            Ok(folder) => folder.flatten().map(|entry| entry.path()).collect(),
            Err(_) => vec![self.sequence.clone()],
        }
    }

    pub(super) fn load(&self) -> Result<Sequence> {
        load(&self.sequence, &self.clip)
    }
}

/// Reads or samples a sequence that fits into memory together with its build.
pub(super) fn load(path: &Path, options: &ClipOptions) -> Result<Sequence> {
    let room = Room::available(sphere_mesh::bytes_a_vertex);
    let extension = path.extension().and_then(|e| e.to_str());
    let gltf = extension.is_some_and(|e| ["glb", "gltf"].iter().any(|g| e.eq_ignore_ascii_case(g)));
    if !gltf || path.is_dir() {
        return asset::load_sequence(path, room);
    }
    let morphed = asset::load_morph(path, options.clip.as_deref(), options.fps, room)?;
    if let Some(sequence) = morphed {
        return Ok(sequence);
    }
    let model = asset::load(path)?;
    let clip = match &options.clip {
        Some(name) => find(&model, name)?,
        None if model.clips.is_empty() => {
            return Err(Error::asset(path, "/animations", "the file has no clip"));
        }
        None => 0,
    };
    rig::sequence(&model, clip, options.fps, room)
}

fn find(model: &Model, name: &str) -> Result<usize> {
    let named = model.clips.iter().position(|clip| clip.name == name);
    let numbered = || name.parse().ok().filter(|&row| row < model.clips.len());
    named.or_else(numbered).ok_or_else(|| {
        let names: Vec<&str> = model.clips.iter().map(|clip| clip.name.as_str()).collect();
        Error::argument("--clip", format!("{name:?} is none of {names:?}"))
    })
}
