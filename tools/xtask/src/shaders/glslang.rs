//! The quick way: glslangValidator, unoptimised.

use std::{fs, path::Path, process::Command};

use crate::Result;

/// Compiles one file of a folder.
pub(crate) fn compile(folder: &Path, file: &str) -> Result<Vec<u32>> {
    let output = std::env::temp_dir().join(format!("dermis-{}-{file}.spv", std::process::id()));
    let run = Command::new("glslangValidator")
        .args(["-V", "--quiet", "--target-env", "vulkan1.2"])
        .arg(format!("-I{}", folder.display()))
        .arg(folder.join(file))
        .arg("-o")
        .arg(&output)
        .output()
        .map_err(|e| format!("glslangValidator: {e} (Debian's package is glslang-tools)"))?;
    if !run.status.success() {
        return Err(format!(
            "{file}\n{}",
            String::from_utf8_lossy(&run.stdout).trim_end()
        ));
    }
    let bytes = fs::read(&output).map_err(|e| format!("{}: {e}", output.display()))?;
    let _ = fs::remove_file(&output);
    Ok(bytes
        .chunks_exact(4)
        .map(|c| u32::from_le_bytes([c[0], c[1], c[2], c[3]]))
        .collect())
}
