//! The header compiles without a warning in the languages that it promises.

use std::process::{Command, Stdio};

use crate::root;

/// Uses every kind of item; block comments and declarations first, for C89.
const PROGRAM: &str = r#"
#include "dermis.h"

int main(void)
{
    dm_context context = { 0 };
    dm_context_desc desc = { 0 };
    dm_result result;
    desc.size = (uint32_t)sizeof desc;
    desc.api_version = DM_API_VERSION;
    desc.flags = DM_CONTEXT_CPU | DM_CONTEXT_VALIDATION;
    result = dm_context_create(&desc, &context);
    if (result != DM_OK || dm_last_error()[0] != '\0') {
        return (int)dm_api_version();
    }
    return dm_context_destroy(context) == DM_ERROR_HANDLE;
}
"#;

fn there(compiler: &str) -> bool {
    let run = Command::new(compiler)
        .arg("--version")
        .stdout(Stdio::null())
        .status();
    run.is_ok_and(|status| status.success())
}

/// Compiles [`PROGRAM`]; skipped, with a message, where the compiler is missing.
fn compiles(compiler: &str, language: &str, standard: &str) {
    if !there(compiler) {
        eprintln!("skipped: no {compiler} here; tools/test installs it");
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let source = folder.path().join("program.txt");
    std::fs::write(&source, PROGRAM).unwrap();
    let output = Command::new(compiler)
        .args(["-x", language, standard])
        .args(["-Wall", "-Wextra", "-pedantic", "-Werror", "-c"])
        .args(["-Wno-missing-field-initializers", "-I"])
        .arg(root().join("include"))
        .arg(source)
        .arg("-o")
        .arg(folder.path().join("program.o"))
        .output()
        .unwrap();
    let complaints = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{standard}: {complaints}");
}

#[test]
fn the_header_is_c89() {
    compiles("cc", "c", "-std=c89");
}

#[test]
fn the_header_is_c11() {
    compiles("cc", "c", "-std=c11");
}

#[test]
fn the_header_is_cpp17() {
    compiles("c++", "c++", "-std=c++17");
}
