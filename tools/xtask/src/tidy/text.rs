//! Files as text: a first line that says what the module is, a length that can be read, no stray white space.

use super::{Tree, code::of_tests};

/// Longest file, in lines.
const LONGEST: usize = 500;

/// Extensions of the files that people write.
const WRITTEN: [&str; 9] = ["rs", "comp", "vert", "frag", "glsl", "toml", "md", "h", "c"];

/// All findings about text.
pub(crate) fn check(tree: &Tree) -> Vec<String> {
    let mut findings = Vec::new();
    for (path, text) in tree.files().filter(|(path, _)| written(path)) {
        if path.ends_with(".rs") && !of_tests(path) && !text.starts_with("//! ") {
            findings.push(format!("{path}:1: the first line is not a `//!` line"));
        }
        let lines = text.lines().count();
        if lines > LONGEST && !path.ends_with(".md") {
            findings.push(format!("{path}: {lines} lines, more than {LONGEST}"));
        }
        white_space(path, text, &mut findings);
    }
    findings
}

fn written(path: &str) -> bool {
    let name = path.rsplit('/').next().unwrap_or(path);
    match name.rsplit_once('.') {
        Some((_, extension)) => WRITTEN.contains(&extension) || name == ".gitignore",
        None => true, // a script
    }
}

fn white_space(path: &str, text: &str, findings: &mut Vec<String>) {
    for (i, line) in text.lines().enumerate() {
        if line.contains('\t') {
            findings.push(format!("{path}:{}: tab", i + 1));
        }
        if line.ends_with([' ', '\t', '\r']) {
            findings.push(format!("{path}:{}: white space at the line's end", i + 1));
        }
    }
    if !text.is_empty() && !text.ends_with('\n') {
        findings.push(format!("{path}: no line end at the end of the file"));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn findings(path: &str, text: &str) -> Vec<String> {
        check(&Tree::of(&[(path, text)]))
    }

    #[test]
    fn a_module_opens_with_what_it_is() {
        assert_eq!(findings("src/a.rs", "//! Does a.\nfn a() {}\n"), [""; 0]);
        assert_eq!(findings("src/a.rs", "fn a() {}\n").len(), 1);
        assert_eq!(findings("src/a.rs", "").len(), 1);
        assert_eq!(findings("src/a/tests.rs", "use super::*;\n"), [""; 0]);
        assert_eq!(findings("shaders/a.comp", "#version 460\n"), [""; 0]);
    }

    #[test]
    fn files_are_at_most_500_lines() {
        let lines = |n: usize| "//! A line.\n".repeat(n);
        assert_eq!(findings("src/a.rs", &lines(500)), [""; 0]);
        assert_eq!(findings("src/a.rs", &lines(501)).len(), 1);
        assert_eq!(findings("shaders/a.comp", &lines(501)).len(), 1);
    }

    #[test]
    fn white_space_is_seen() {
        assert_eq!(findings("shaders/a.glsl", "a\tb\n").len(), 1);
        assert_eq!(findings("tools/demo", "a \n").len(), 1);
        assert_eq!(
            findings("Cargo.toml", "a\r\nb\n").len(),
            0,
            "lines() strips CRLF"
        );
        assert_eq!(findings("Cargo.toml", "a").len(), 1);
        assert_eq!(findings("assets/a.glb", "\t \n"), [""; 0]);
    }
}
