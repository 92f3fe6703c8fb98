//! `cargo xtask header`: writes `include/dermis.h` from the items and documentation of `src/capi`.

use std::{fs, path::Path};

use cbindgen::{
    Builder, Config, DocumentationStyle, EnumConfig, ExportConfig, Language, ParseConfig, Style,
};

use crate::{Result, root};

const HEADER: &str = "include/dermis.h";
const SOURCE: &str = "src/capi/mod.rs";

const PREAMBLE: &str = "\
/*
 * dermis: real-time character skin with contact and volume, on Vulkan.
 *
 * A context is a device, a rig a prepared character, a deformer one instance of a rig in a context, or several that share its
 * fields: matrices of the joints go in, positions and normals come out. A mesh can be bent along a spine, and a captured sequence
 * made a sphere-mesh, without any of these; particles bounce off a level of a sphere-mesh in a context.
 *
 * Handles are numbers. Zero is none; a handle that is used after its object was destroyed is refused with an error. An
 * object stays alive as long as another one uses it, so that they may be destroyed in any order.
 *
 * Functions may be called on any thread; calls on one object wait for each other. All but dm_api_version and dm_last_error
 * return a dm_result; dm_last_error says what went wrong.
 *
 * Structs begin with their size, which the caller sets, also where the function fills the rest. A size of an earlier version,
 * which had fewer members, will do: those that it lacks are 0. Text is UTF-8. Matrices are
 * 16 numbers, column-major. Rest space is that in which the mesh is modelled, model space that of the posed result. Arrays
 * may have any alignment. Nothing that a caller passes is kept, but the log of a context.
 *
 * Generated from src/capi by `cargo xtask header`.
 */";

/// Runs the task with its arguments.
pub(crate) fn run(arguments: &[String]) -> Result<()> {
    let check = match arguments {
        [] => false,
        [check] if check == "--check" => true,
        _ => return Err("header takes --check or nothing".into()),
    };
    let root = root();
    let header = generate(&root.join(SOURCE))?;
    let path = root.join(HEADER);
    if !check {
        return fs::write(&path, header).map_err(|e| format!("{}: {e}", path.display()));
    }
    let committed = fs::read_to_string(&path).map_err(|e| format!("{}: {e}", path.display()))?;
    if committed == header {
        println!("header: {HEADER} is what src/capi makes");
        Ok(())
    } else {
        Err(format!(
            "{HEADER} is not what src/capi makes: run `cargo xtask header`"
        ))
    }
}

/// The header of a module and those below it.
fn generate(module: &Path) -> Result<String> {
    let builder = Builder::new().with_config(config()).with_src(module);
    let mut bytes = Vec::new();
    let bindings = builder.generate().map_err(|e| e.to_string())?;
    bindings.write(&mut bytes);
    let header = String::from_utf8(bytes).map_err(|e| e.to_string())?;
    Ok(c89(&short(&header)))
}

fn config() -> Config {
    Config {
        language: Language::C,
        header: Some(PREAMBLE.into()),
        include_guard: Some("DERMIS_H".into()),
        no_includes: true,
        sys_includes: vec!["stddef.h".into(), "stdint.h".into()],
        cpp_compat: true,
        usize_is_size_t: true,
        style: Style::Both,
        documentation_style: DocumentationStyle::C,
        line_length: 110,
        tab_width: 4,
        enumeration: EnumConfig::default(),
        export: ExportConfig::default(),
        parse: ParseConfig::default(),
        ..Config::default()
    }
}

/// Comments of one line in one line.
fn short(header: &str) -> String {
    let mut lines = header.lines().peekable();
    let mut text = String::with_capacity(header.len());
    while let Some(line) = lines.next() {
        text.push_str(line);
        if line.trim() == "/*"
            && let Some(only) = lines.next()
        {
            if lines.next_if(|end| end.trim() == "*/").is_some() {
                text.push(' ');
                text.push_str(only.trim());
                text.push_str(" */");
            } else {
                text.push('\n');
                text.push_str(only);
            }
        }
        text.push('\n');
    }
    text
}

/// What C89 wants otherwise: block comments behind directives, and no comma behind the last enumerator. Rust's heading over
/// what pointers have to be says it in a word of C.
fn c89(header: &str) -> String {
    let mut text = String::with_capacity(header.len());
    for line in header.lines() {
        let line = match line.split_once("//") {
            Some((code, comment)) if code.starts_with('#') => {
                format!("{}  /* {} */", code.trim_end(), comment.trim())
            }
            _ => line.trim_end().to_owned(),
        };
        let line = line.replace("# Safety", "Pointers:");
        if line.starts_with('}') && text.ends_with(",\n") {
            text.truncate(text.len() - 2);
            text.push('\n');
        }
        text.push_str(&line);
        text.push('\n');
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn comments_of_one_line_are_one_line() {
        let given = "  /*\n   A.\n   */\n  a\n/*\n B\n c.\n */\nb\n";
        let wanted = "  /* A. */\n  a\n/*\n B\n c.\n */\nb\n";
        assert_eq!(short(given), wanted);
    }

    #[test]
    fn what_c89_refuses_is_mended() {
        let given = "enum a {\n    A = 0,\n}\n#ifdef X\n#endif  // X\n";
        let wanted = "enum a {\n    A = 0\n}\n#ifdef X\n#endif  /* X */\n";
        assert_eq!(c89(given), wanted);
    }
}
