//! `cargo xtask tidy`: the project's rules about modules, passes and files.

mod code;
mod modules;
mod passes;
mod text;

use std::{fs, path::Path};

use crate::Result;

/// Text files of the project by path from the root, such as `src/mesh/mod.rs`, sorted. Of SPIR-V only the names.
pub(crate) struct Tree(Vec<(String, String)>);

impl Tree {
    /// Paths and contents.
    fn files(&self) -> impl Iterator<Item = (&str, &str)> {
        self.0
            .iter()
            .map(|(path, text)| (path.as_str(), text.as_str()))
    }

    /// Rust files.
    fn rust(&self) -> impl Iterator<Item = (&str, &str)> {
        self.files().filter(|(path, _)| path.ends_with(".rs"))
    }

    /// Content of one file.
    fn text(&self, path: &str) -> Option<&str> {
        self.files().find(|(p, _)| *p == path).map(|(_, text)| text)
    }

    #[cfg(test)]
    fn of(files: &[(&str, &str)]) -> Self {
        Self(
            files
                .iter()
                .map(|(path, text)| (path.to_string(), text.to_string()))
                .collect(),
        )
    }
}

/// Checks the project at `root`; prints each finding.
pub(crate) fn run(root: &Path) -> Result<()> {
    let tree = read(root)?;
    let findings = findings(&tree);
    for finding in &findings {
        eprintln!("{finding}");
    }
    match findings.len() {
        0 => {
            println!("tidy: {} files", tree.0.len());
            Ok(())
        }
        count => Err(format!("tidy: {count} findings")),
    }
}

fn findings(tree: &Tree) -> Vec<String> {
    [modules::check(tree), passes::check(tree), text::check(tree)].concat()
}

const FOLDERS: [&str; 6] = ["src", "shaders", "tools", "tests", "benches", ".ci"];
const LONE_FILES: [&str; 6] = [
    "build.rs",
    "Cargo.toml",
    "README.md",
    "CHANGELOG.md",
    "deny.toml",
    ".gitignore",
];

fn read(root: &Path) -> Result<Tree> {
    let mut files = Vec::new();
    for name in LONE_FILES {
        if let Ok(text) = fs::read_to_string(root.join(name)) {
            files.push((name.to_string(), text));
        }
    }
    for folder in FOLDERS.iter().filter(|f| root.join(f).is_dir()) {
        walk(root, folder, &mut files)?;
    }
    files.sort();
    Ok(Tree(files))
}

fn walk(root: &Path, folder: &str, files: &mut Vec<(String, String)>) -> Result<()> {
    let entries = fs::read_dir(root.join(folder)).map_err(|e| format!("{folder}: {e}"))?;
    for entry in entries.flatten() {
        let path = format!("{folder}/{}", entry.file_name().to_string_lossy());
        if entry.path().is_dir() {
            walk(root, &path, files)?;
        } else {
            // What is not text is listed by name only.
            let text = fs::read(entry.path()).map_err(|e| format!("{path}: {e}"))?;
            files.push((path, String::from_utf8(text).unwrap_or_default()));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn this_project_is_read() {
        let tree = read(&crate::root()).expect("readable");
        assert!(tree.text("src/lib.rs").is_some());
        assert!(tree.text("tools/xtask/src/tidy/mod.rs").is_some());
    }

    #[test]
    fn findings_of_all_rules_are_collected() {
        let tree = Tree::of(&[
            ("src/mesh/mod.rs", "use crate::gpu;\t\n"),
            ("shaders/x.comp", "\n"),
        ]);
        let all = findings(&tree).join("\n");
        for part in ["may not use", "tab", "//!", "manifest", "src/pass/x.rs"] {
            assert!(all.contains(part), "{part} not in:\n{all}");
        }
    }
}
