//! Which shaders there are and what each was compiled from; shared by `build.rs` and `cargo xtask shaders`.

use std::{
    collections::BTreeMap,
    fs,
    path::{Path, PathBuf},
};

/// A shader source and the fingerprint of everything that it is compiled from.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Shader {
    /// File name in the shader folder, such as `project.comp`.
    pub(crate) file: String,
    /// FNV-1a 64 over the source and its includes.
    pub(crate) hash: u64,
}

impl Shader {
    /// File name of the SPIR-V: `project.comp` → `project.spv`, `mesh.vert` → `mesh.vert.spv`.
    pub(crate) fn spirv(&self) -> String {
        let stem = self.file.strip_suffix(".comp").unwrap_or(&self.file);
        format!("{stem}.spv")
    }
}

/// The shaders of a folder, sorted by file name.
///
/// # Errors
/// A sentence where a file or an include cannot be read.
pub(crate) fn shaders(folder: &Path) -> Result<Vec<Shader>, String> {
    let entries = fs::read_dir(folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    let mut files: Vec<PathBuf> = entries.flatten().map(|e| e.path()).collect();
    files.retain(|p| {
        matches!(
            p.extension().and_then(|e| e.to_str()),
            Some("comp" | "vert" | "frag")
        )
    });
    files.sort();
    files
        .iter()
        .map(|path| {
            let file = path
                .file_name()
                .unwrap_or_default()
                .to_string_lossy()
                .into_owned();
            let mut seen = Vec::new();
            expand(folder, path, &mut seen)?;
            let text = seen.into_iter().map(|(_, text)| text).collect::<String>();
            Ok(Shader {
                file,
                hash: fnv1a(text.as_bytes()),
            })
        })
        .collect()
}

/// Appends a file and what it includes to `seen`, each once, in the order of their first mention.
fn expand(folder: &Path, path: &Path, seen: &mut Vec<(PathBuf, String)>) -> Result<(), String> {
    if seen.iter().any(|(p, _)| p == path) {
        return Ok(());
    }
    let text = fs::read_to_string(path).map_err(|e| format!("{}: {e}", path.display()))?;
    // Line ends do not count: a checkout may rewrite them.
    let text = text.replace('\r', "");
    seen.push((path.to_path_buf(), text.clone()));
    for name in text.lines().filter_map(included) {
        let target = resolve(folder, path, name)
            .ok_or_else(|| format!("{}: include {name:?} not found", path.display()))?;
        expand(folder, &target, seen)?;
    }
    Ok(())
}

/// The name in an `#include "name"` line.
fn included(line: &str) -> Option<&str> {
    let rest = line
        .trim_start()
        .strip_prefix('#')?
        .trim_start()
        .strip_prefix("include")?;
    rest.trim().strip_prefix('"')?.split('"').next()
}

/// Looks for an include beside the including file, then in the shader folder.
pub(crate) fn resolve(folder: &Path, from: &Path, name: &str) -> Option<PathBuf> {
    let beside = from.parent().unwrap_or(folder).join(name);
    [beside, folder.join(name)]
        .into_iter()
        .find(|p| p.is_file())
}

/// Fowler–Noll–Vo hash, variant 1a, 64 bits.
pub(crate) fn fnv1a(bytes: &[u8]) -> u64 {
    bytes.iter().fold(0xcbf2_9ce4_8422_2325, |hash, byte| {
        (hash ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01b3)
    })
}

/// Text of the manifest: a line a shader, file name and hash.
pub(crate) fn manifest(shaders: &[Shader]) -> String {
    shaders
        .iter()
        .map(|s| format!("{} {:016x}\n", s.file, s.hash))
        .collect()
}

/// First disagreement between the sources of a folder and its `spirv/manifest.txt`, as the line that a developer needs.
pub(crate) fn stale(folder: &Path) -> Result<Option<String>, String> {
    let text = fs::read_to_string(folder.join("spirv/manifest.txt")).unwrap_or_default();
    let mut listed: BTreeMap<&str, &str> = text
        .lines()
        .filter_map(|line| line.split_once(' '))
        .collect();
    for shader in shaders(folder)? {
        let compiled = listed.remove(shader.file.as_str());
        let exists = folder.join("spirv").join(shader.spirv()).is_file();
        if compiled != Some(format!("{:016x}", shader.hash).as_str()) || !exists {
            return Ok(Some(format!(
                "shaders/{} is newer than its SPIR-V: run `cargo xtask shaders`",
                shader.file
            )));
        }
    }
    let orphan = listed.keys().next();
    Ok(orphan.map(|file| {
        format!("shaders/{file} is gone but its SPIR-V is not: run `cargo xtask shaders`")
    }))
}
