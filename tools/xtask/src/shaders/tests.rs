//! Compiling, checking and noticing what is stale, on small shaders of its own.
#![allow(clippy::unwrap_used)]

use std::{fs, path::PathBuf};

use super::*;

/// A shader folder of one test, removed at its end.
struct Folder(PathBuf);

impl Folder {
    fn new(test: &str) -> Self {
        let path = std::env::temp_dir().join(format!("dermis-xtask-{}-{test}", std::process::id()));
        fs::create_dir_all(path.join("shared")).unwrap();
        let folder = Self(path);
        folder.put("shared/inner.glsl", "const float INNER = 1.0;\n");
        folder.put("shared/outer.glsl", "#include \"shared/inner.glsl\"\n");
        folder.put(
            "fill.comp",
            "#version 460\n#extension GL_GOOGLE_include_directive : require\n#include \"shared/outer.glsl\"\n\
             layout(local_size_x = 64) in;\n\
             layout(std430, set = 0, binding = 0) buffer Target { float values[]; };\n\
             void main() { values[gl_GlobalInvocationID.x] = INNER; }\n",
        );
        folder
    }

    fn put(&self, file: &str, text: &str) {
        fs::write(self.0.join(file), text).unwrap();
    }

    fn stale(&self) -> Option<String> {
        sources::stale(&self.0).unwrap()
    }

    /// Writes a manifest that matches, and empty SPIR-V.
    fn pretend_compiled(&self) {
        let shaders = sources::shaders(&self.0).unwrap();
        let mut files = vec![(
            "manifest.txt".to_string(),
            sources::manifest(&shaders).into_bytes(),
        )];
        files.extend(shaders.iter().map(|s| (s.spirv(), Vec::new())));
        write(&self.0, &files).unwrap();
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

#[test]
fn a_change_of_source_or_include_is_stale() {
    let folder = Folder::new("stale");
    let line = "shaders/fill.comp is newer than its SPIR-V: run `cargo xtask shaders`";
    assert_eq!(
        folder.stale().as_deref(),
        Some(line),
        "nothing compiled yet"
    );
    folder.pretend_compiled();
    assert_eq!(folder.stale(), None);
    folder.put("shared/inner.glsl", "const float INNER = 2.0;\n");
    assert_eq!(folder.stale().as_deref(), Some(line));
    folder.pretend_compiled();
    fs::remove_file(folder.0.join("spirv/fill.spv")).unwrap();
    assert_eq!(folder.stale().as_deref(), Some(line), "no SPIR-V");
    folder.pretend_compiled();
    fs::remove_file(folder.0.join("fill.comp")).unwrap();
    assert!(folder.stale().unwrap().contains("fill.comp is gone"));
}

#[test]
fn line_ends_are_not_a_change() {
    let folder = Folder::new("crlf");
    folder.pretend_compiled();
    folder.put("shared/inner.glsl", "const float INNER = 1.0;\r\n");
    assert_eq!(folder.stale(), None);
}

#[test]
fn a_missing_include_is_named() {
    let folder = Folder::new("include");
    folder.put("fill.comp", "#include \"shared/none.glsl\"\n");
    let error = sources::shaders(&folder.0).unwrap_err();
    assert!(
        error.contains("fill.comp") && error.contains("shared/none.glsl"),
        "{error}"
    );
}

#[test]
fn check_rejects_other_bytes_and_orphans() {
    let folder = Folder::new("check");
    let files = [
        ("fill.spv".to_string(), vec![1, 2]),
        ("manifest.txt".to_string(), vec![3]),
    ];
    assert!(check(&folder.0, &files).is_err(), "nothing written yet");
    write(&folder.0, &files).unwrap();
    assert_eq!(check(&folder.0, &files), Ok(()));
    let other = [("fill.spv".to_string(), vec![1, 9]), files[1].clone()];
    assert!(check(&folder.0, &other).is_err());
    folder.put("spirv/gone.spv", "");
    assert!(check(&folder.0, &files).is_err());
    write(&folder.0, &files).unwrap();
    assert_eq!(check(&folder.0, &files), Ok(()), "writing removes orphans");
}

#[test]
fn hash_is_fnv_1a() {
    // Vectors of the hash's own specification.
    assert_eq!(sources::fnv1a(b""), 0xcbf2_9ce4_8422_2325);
    assert_eq!(sources::fnv1a(b"foobar"), 0x8594_4171_f739_67e8);
}

#[cfg(feature = "shaderc")]
#[test]
fn shaderc_keeps_names_and_no_source() {
    let folder = Folder::new("shaderc");
    let request = Request {
        check: false,
        glslang: false,
        folder: folder.0.clone(),
    };
    let compiled = compile(&request).unwrap();
    assert_eq!(
        compiled,
        compile(&request).unwrap(),
        "same bytes every time"
    );
    let spirv = &compiled[0].1;
    let has = |text: &[u8]| spirv.windows(text.len()).any(|w| w == text);
    assert!(
        has(b"values") && has(b"Target") && !has(b"fill.comp") && !has(b"gl_GlobalInvocationID.x]")
    );
}
