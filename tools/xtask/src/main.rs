//! Maintenance of the dermis workspace: `cargo xtask shaders | header | tidy | assets | compare`.

mod shaders;
// `build.rs` uses the rest.
#[allow(dead_code)]
#[path = "../../../shaders/sources.rs"]
mod sources;
mod tidy;

#[cfg(feature = "assets")]
mod assets;
#[cfg(feature = "compare")]
mod compare;
#[cfg(feature = "header")]
mod header;

use std::{
    path::{Path, PathBuf},
    process::{Command, ExitCode},
};

/// A sentence for whoever ran the task.
type Result<T> = std::result::Result<T, String>;

const USAGE: &str = "\
Usage: cargo xtask TASK

  shaders [--check] [--glslang] [--dir FOLDER]
          compiles FOLDER/*.comp, *.vert and *.frag (default: shaders) to FOLDER/spirv;
          --check compares instead of writing;
          --glslang compiles with the glslangValidator on the PATH, for quick trials:
          what it writes does not pass --check
  header [--check]
          writes include/dermis.h from src/capi; --check compares instead of writing
  tidy    checks modules, passes and files against the project's rules
  assets [--check] [NAME..]
          makes assets/arm.glb, hand.glb and mannequin.glb; --check compares instead of writing
  compare A.png B.png [MEAN]
          tells how much two pictures differ; fails beyond MEAN of 255 a channel on average (default: 1)";

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    match run(&arguments) {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("xtask: {message}");
            ExitCode::FAILURE
        }
    }
}

fn run(arguments: &[String]) -> Result<()> {
    let (task, rest) = arguments.split_first().ok_or(USAGE)?;
    match task.as_str() {
        "shaders" => shaders::run(rest),
        "tidy" if rest.is_empty() => tidy::run(&root()),
        #[cfg(feature = "header")]
        "header" => header::run(rest),
        #[cfg(not(feature = "header"))]
        "header" => again(&["header"], None, arguments),
        #[cfg(feature = "assets")]
        "assets" => assets::run(rest),
        #[cfg(not(feature = "assets"))]
        "assets" => again(&["assets"], None, arguments),
        #[cfg(feature = "compare")]
        "compare" => compare::run(rest),
        #[cfg(not(feature = "compare"))]
        "compare" => again(&["compare"], None, arguments),
        "help" | "--help" | "-h" => {
            println!("{USAGE}");
            Ok(())
        }
        _ => Err(format!("unknown task or argument\n\n{USAGE}")),
    }
}

/// Root of the workspace.
///
/// `cargo run` says where the package lies; a program built in a target folder that several checkouts share may not know.
fn root() -> PathBuf {
    let package = std::env::var_os("CARGO_MANIFEST_DIR");
    let mut path = PathBuf::from(package.unwrap_or_else(|| env!("CARGO_MANIFEST_DIR").into()));
    path.pop();
    path.pop();
    path
}

/// Runs this program again with other features, in a target folder of its own where one is given.
fn again(features: &[&str], target: Option<&Path>, arguments: &[String]) -> Result<()> {
    let mut command = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    command.current_dir(root());
    command.args([
        "run",
        "--quiet",
        "--package",
        "xtask",
        "--no-default-features",
        "--features",
    ]);
    command.arg(features.join(","));
    if let Some(target) = target {
        command.arg("--target-dir").arg(target);
    }
    let status = command
        .arg("--")
        .args(arguments)
        .status()
        .map_err(|e| format!("cargo: {e}"))?;
    // The other process has said why.
    if status.success() {
        Ok(())
    } else {
        std::process::exit(status.code().unwrap_or(1))
    }
}
