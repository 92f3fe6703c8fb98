//! Runs the program and finds files for it.
#![allow(clippy::unwrap_used, dead_code, unreachable_pub)]

use std::{
    path::{Path, PathBuf},
    process::{Command, Output},
};

/// Runs `dermis` with `args` to its end.
pub fn dermis<S: AsRef<std::ffi::OsStr>>(args: &[S]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_dermis"))
        .args(args)
        .output()
        .unwrap()
}

/// The program must have ended well; its standard output.
pub fn good<S: AsRef<std::ffi::OsStr>>(args: &[S]) -> String {
    let output = dermis(args);
    let words: Vec<_> = args.iter().map(AsRef::as_ref).collect();
    assert!(output.status.success(), "{words:?}: {}", stderr(&output));
    String::from_utf8(output.stdout).unwrap()
}

/// The program must have failed with exit code 1 and one line `error: …`, which is returned.
pub fn refused<S: AsRef<std::ffi::OsStr>>(args: &[S]) -> String {
    let output = dermis(args);
    let text = stderr(&output);
    assert_eq!(output.status.code(), Some(1), "{text}");
    let errors: Vec<&str> = text.lines().filter(|l| l.starts_with("error: ")).collect();
    assert_eq!(errors.len(), 1, "{text}");
    assert_eq!(text.lines().last(), errors.first().copied(), "{text}");
    errors[0].to_string()
}

/// Standard error as text.
pub fn stderr(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// A file of the project's own assets.
pub fn asset(name: &str) -> String {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../assets");
    let path = root.join(name);
    assert!(path.is_file(), "{} is missing", path.display());
    path.to_str().unwrap().into()
}

/// A file of the shared data; `None`, with a line that says so, where the folder does not exist.
pub fn data(name: &str) -> Option<String> {
    let root = std::env::var_os("DERMIS_DATA").map_or_else(
        || Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data"),
        PathBuf::from,
    );
    if !root.is_dir() {
        eprintln!("skipped: no data at {} (DERMIS_DATA)", root.display());
        return None;
    }
    let path = root.join(name);
    assert!(path.is_file(), "{} is missing", path.display());
    Some(path.to_str().unwrap().into())
}

/// Names in a folder, sorted.
pub fn names(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).unwrap();
    let mut names: Vec<String> = entries
        .map(|e| e.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    names
}
