//! The compiler whose output is committed: shaderc, optimised for speed, names kept for reflection.

use std::{fs, path::Path};

use shaderc::{
    CompileOptions, Compiler, EnvVersion, OptimizationLevel, ResolvedInclude, ShaderKind,
    SourceLanguage, SpirvVersion, TargetEnv,
};

use crate::{Result, sources};

/// Compiles one file of a folder.
pub(crate) fn compile(folder: &Path, file: &str) -> Result<Vec<u32>> {
    let path = folder.join(file);
    let text = fs::read_to_string(&path).map_err(|e| format!("{}: {e}", path.display()))?;
    let kind = match path.extension().and_then(|e| e.to_str()) {
        Some("vert") => ShaderKind::Vertex,
        Some("frag") => ShaderKind::Fragment,
        _ => ShaderKind::Compute,
    };
    let compiler = Compiler::new().map_err(|e| e.to_string())?;
    let options = options(folder)?;
    let result = compiler
        .compile_into_spirv(&text, kind, file, "main", Some(&options))
        .map_err(|e| e.to_string())?;
    if result.get_num_warnings() > 0 {
        eprint!("{}", result.get_warning_messages());
    }
    Ok(result.as_binary().to_vec())
}

fn options(folder: &Path) -> Result<CompileOptions<'_>> {
    let mut options = CompileOptions::new().map_err(|e| e.to_string())?;
    options.set_source_language(SourceLanguage::GLSL);
    options.set_target_env(TargetEnv::Vulkan, EnvVersion::Vulkan1_2 as u32);
    options.set_target_spirv(SpirvVersion::V1_5);
    options.set_optimization_level(OptimizationLevel::Performance);
    // Without debug information shaderc strips the names that the pipelines' reflection checks.
    options.set_generate_debug_info();
    options.set_include_callback(move |name, _, from, _| {
        // The including file is named as we named it: relative to the folder, or as resolved below.
        let target = sources::resolve(folder, &folder.join(from), name)
            .ok_or_else(|| format!("{name} not found"))?;
        let content = fs::read_to_string(&target).map_err(|e| e.to_string())?;
        let relative = target.strip_prefix(folder).unwrap_or(&target);
        Ok(ResolvedInclude {
            resolved_name: relative.display().to_string(),
            content,
        })
    });
    Ok(options)
}
