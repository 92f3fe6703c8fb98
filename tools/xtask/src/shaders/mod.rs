//! `cargo xtask shaders`: GLSL to SPIR-V.

mod glslang;
#[cfg(feature = "shaderc")]
mod shaderc;
mod strip;

use std::{
    fs,
    path::{Path, PathBuf},
};

use crate::{
    Result, root,
    sources::{self, Shader},
};

/// What the command line asks for.
struct Request {
    check: bool,
    glslang: bool,
    folder: PathBuf,
}

/// Compiles all shaders, or checks that what is there is what compiling gives.
pub(crate) fn run(arguments: &[String]) -> Result<()> {
    let request = parse(arguments)?;
    if !request.glslang && cfg!(not(feature = "shaderc")) {
        return with_shaderc(arguments);
    }
    let compiled = compile(&request)?;
    let count = compiled.len() - 1;
    if request.check {
        check(&request.folder, &compiled)?;
        println!("{count} shaders: SPIR-V is up to date");
    } else {
        write(&request.folder, &compiled)?;
        println!("{count} shaders compiled");
    }
    Ok(())
}

fn parse(arguments: &[String]) -> Result<Request> {
    let folder = root().join("shaders");
    let mut request = Request {
        check: false,
        glslang: false,
        folder,
    };
    let mut rest = arguments.iter();
    while let Some(argument) = rest.next() {
        match argument.as_str() {
            "--check" => request.check = true,
            "--glslang" => request.glslang = true,
            "--dir" => request.folder = rest.next().ok_or("--dir: which folder?")?.into(),
            other => return Err(format!("shaders: unknown argument {other:?}")),
        }
    }
    Ok(request)
}

/// The compiler is minutes of C++, so it has a target folder that no other build touches.
fn with_shaderc(arguments: &[String]) -> Result<()> {
    let target = std::env::var_os("DERMIS_SHADERC_TARGET")
        .map_or_else(|| root().join("target/shaderc"), PathBuf::from);
    if !target.exists() {
        eprintln!(
            "building shaderc once; this takes 4 to 14 minutes and needs cmake, a C++ compiler and python3"
        );
    }
    let mut again = vec!["shaders".to_string()];
    again.extend_from_slice(arguments);
    crate::again(&["shaderc"], Some(&target), &again)
}

/// File names and contents below `spirv/`, the manifest last.
fn compile(request: &Request) -> Result<Vec<(String, Vec<u8>)>> {
    let shaders = sources::shaders(&request.folder)?;
    let mut files = Vec::new();
    for shader in &shaders {
        let words = compile_one(request, shader)?;
        let bytes = strip::source_text(&words)
            .map_err(|e| format!("{}: {e}", shader.file))?
            .iter()
            .flat_map(|w| w.to_le_bytes())
            .collect();
        files.push((shader.spirv(), bytes));
    }
    files.push((
        "manifest.txt".into(),
        sources::manifest(&shaders).into_bytes(),
    ));
    Ok(files)
}

#[cfg(feature = "shaderc")]
fn compile_one(request: &Request, shader: &Shader) -> Result<Vec<u32>> {
    if request.glslang {
        return glslang::compile(&request.folder, &shader.file);
    }
    shaderc::compile(&request.folder, &shader.file)
}

#[cfg(not(feature = "shaderc"))]
fn compile_one(request: &Request, shader: &Shader) -> Result<Vec<u32>> {
    glslang::compile(&request.folder, &shader.file)
}

fn check(folder: &Path, compiled: &[(String, Vec<u8>)]) -> Result<()> {
    let spirv = folder.join("spirv");
    for (name, bytes) in compiled {
        let path = spirv.join(name);
        let there = fs::read(&path).map_err(|e| format!("{}: {e}", path.display()))?;
        if there != *bytes {
            return Err(format!(
                "{} is not what its source compiles to: run `cargo xtask shaders`",
                path.display()
            ));
        }
    }
    match orphans(&spirv, compiled)?.first() {
        Some(path) => Err(format!(
            "{} has no source: run `cargo xtask shaders`",
            path.display()
        )),
        None => Ok(()),
    }
}

fn write(folder: &Path, compiled: &[(String, Vec<u8>)]) -> Result<()> {
    let spirv = folder.join("spirv");
    fs::create_dir_all(&spirv).map_err(|e| format!("{}: {e}", spirv.display()))?;
    for path in orphans(&spirv, compiled)? {
        fs::remove_file(&path).map_err(|e| format!("{}: {e}", path.display()))?;
    }
    for (name, bytes) in compiled {
        let path = spirv.join(name);
        // An untouched file keeps its time, and what embeds it is not compiled again.
        if fs::read(&path).is_ok_and(|there| there == *bytes) {
            continue;
        }
        fs::write(&path, bytes).map_err(|e| format!("{}: {e}", path.display()))?;
    }
    Ok(())
}

/// SPIR-V files that no source gives.
fn orphans(spirv: &Path, compiled: &[(String, Vec<u8>)]) -> Result<Vec<PathBuf>> {
    let entries = fs::read_dir(spirv).map_err(|e| format!("{}: {e}", spirv.display()))?;
    let known = |path: &Path| compiled.iter().any(|(name, _)| path.ends_with(name));
    let mut paths: Vec<PathBuf> = entries
        .flatten()
        .map(|e| e.path())
        .filter(|p| p.extension().is_some_and(|e| e == "spv") && !known(p))
        .collect();
    paths.sort();
    Ok(paths)
}

#[cfg(test)]
mod tests;
