//! The library exports what the header declares and nothing else.

use std::{collections::BTreeSet, path::PathBuf, process::Command};

use crate::{
    calls::CALLS, flesh_calls::FLESH_CALLS, header, host_calls::HOST_CALLS, root,
    sphere_calls::SPHERE_CALLS,
};

/// Names of the functions that the header declares.
fn declared() -> BTreeSet<String> {
    let header = header();
    let lines = header
        .lines()
        .filter(|line| line.starts_with(|c: char| c.is_ascii_lowercase()));
    let names = lines.filter(|line| !line.starts_with("typedef"));
    names
        .filter_map(|line| {
            let before = line.split_once('(')?.0;
            let name = before.rsplit([' ', '*']).next()?;
            name.starts_with("dm_").then(|| name.to_owned())
        })
        .collect()
}

/// The library as it is now: tests do not link a C library, so that cargo does not build it for them.
fn library() -> PathBuf {
    let program = std::env::current_exe().unwrap();
    // target/debug/deps/abi-…
    let folder = program.parent().unwrap().parent().unwrap();
    let built = Command::new(env!("CARGO"))
        .args(["build", "--quiet", "--package", "dermis-c", "--target-dir"])
        .arg(folder.parent().unwrap())
        .current_dir(root())
        .status();
    assert!(built.unwrap().success());
    folder.join("libdermis.so")
}

#[cfg(target_os = "linux")]
#[test]
fn the_symbols_are_those_of_the_header() {
    let output = match Command::new("nm")
        .args(["-D", "--defined-only", "--format=posix"])
        .arg(library())
        .output()
    {
        Ok(output) => output,
        Err(error) => {
            eprintln!("skipped: nm: {error}; it comes with the linker");
            return;
        }
    };
    let text = String::from_utf8(output.stdout).unwrap();
    let exported: BTreeSet<String> = text
        .lines()
        .filter_map(|line| Some(line.split_once(' ')?.0.to_owned()))
        .collect();
    assert_eq!(exported, declared());
}

#[test]
fn every_function_is_swept() {
    let calls = CALLS.iter().chain(FLESH_CALLS).chain(SPHERE_CALLS);
    let calls = calls.chain(HOST_CALLS);
    let names = calls.map(|call| call.name);
    let swept: BTreeSet<String> = names.map(str::to_owned).collect();
    let mut declared = declared();
    // They take nothing and cannot fail.
    for name in ["dm_api_version", "dm_last_error"] {
        assert!(declared.remove(name), "{name}");
    }
    assert_eq!(swept, declared);
}
