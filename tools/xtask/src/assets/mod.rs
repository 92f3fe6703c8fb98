//! `cargo xtask assets`: the bundled characters, made from formulas alone.
//!
//! The same bytes on every machine: only operations that IEEE 754 rounds exactly (no library sine, no fused
//! multiply-add), in a fixed order.

mod arm;
mod body;
mod gait;
mod grid;
mod hand;
mod mannequin;
mod motion;
mod shape;
mod stunts;
mod surface;
mod tail;
mod weights;

use std::fs;

use dermis::asset::{Model, write_glb_skinned};

use crate::{Result, root};

/// Makes a character.
type Maker = fn() -> Result<Model>;

/// The characters by name.
const CHARACTERS: [(&str, Maker); 4] = [
    ("arm", arm::model),
    ("hand", hand::model),
    ("mannequin", mannequin::model),
    ("tail", tail::model),
];

/// Makes all characters, or those named; with `--check` compares what is there.
pub(crate) fn run(arguments: &[String]) -> Result<()> {
    let check = arguments.iter().any(|a| a == "--check");
    let names: Vec<&str> = arguments
        .iter()
        .map(String::as_str)
        .filter(|a| *a != "--check")
        .collect();
    if let Some(unknown) = names
        .iter()
        .find(|n| CHARACTERS.iter().all(|(name, _)| name != *n))
    {
        return Err(format!("assets: no character named {unknown:?}"));
    }
    let wanted = |name: &str| names.is_empty() || names.contains(&name);
    for (name, make) in CHARACTERS.into_iter().filter(|(name, _)| wanted(name)) {
        let model = make().map_err(|e| format!("{name}: {e}"))?;
        deliver(name, &model, check)?;
        let (vertices, joints) = (model.positions.len(), model.joints.len());
        println!(
            "assets/{name}.glb: {vertices} vertices, {} triangles, {joints} joints",
            model.triangles.len()
        );
    }
    Ok(())
}

fn deliver(name: &str, model: &Model, check: bool) -> Result<()> {
    let path = root().join(format!("assets/{name}.glb"));
    if !check {
        fs::create_dir_all(root().join("assets")).map_err(|e| format!("assets: {e}"))?;
        return write_glb_skinned(&path, model).map_err(|e| e.to_string());
    }
    let trial = std::env::temp_dir().join(format!("dermis-{}-{name}.glb", std::process::id()));
    write_glb_skinned(&trial, model).map_err(|e| e.to_string())?;
    let made = fs::read(&trial).map_err(|e| e.to_string())?;
    let _ = fs::remove_file(&trial);
    let there = fs::read(&path).map_err(|e| format!("{}: {e}", path.display()))?;
    if made == there {
        Ok(())
    } else {
        Err(format!("{name}.glb differs: run `cargo xtask assets`"))
    }
}

#[cfg(test)]
mod tests;
