//! Rust source without what is not code: comments, literals and test modules.

/// The code with comments and the insides of string and character literals blanked; lines keep their numbers.
pub(crate) fn bare(source: &str) -> String {
    let characters: Vec<char> = source.chars().collect();
    let mut out = String::with_capacity(source.len());
    let mut at = 0;
    while at < characters.len() {
        let end = skip(&characters, at);
        if end == at {
            out.push(characters[at]);
            at += 1;
        } else {
            out.extend(
                characters[at..end]
                    .iter()
                    .map(|c| if *c == '\n' { '\n' } else { ' ' }),
            );
            at = end;
        }
    }
    out
}

/// Where the comment or literal that starts at `at` ends; `at` itself where none does.
fn skip(c: &[char], at: usize) -> usize {
    let next = c.get(at + 1).copied().unwrap_or(' ');
    match c[at] {
        '/' if next == '/' => find(c, at, "\n"),
        '/' if next == '*' => find(c, at + 2, "*/") + 2,
        'r' if !follows_word(c, at) && (next == '"' || next == '#') => raw_string(c, at),
        '"' => quoted(c, at, '"'),
        // A lifetime is not a literal: 'a is not followed by a closing quote.
        '\'' if next == '\\' || c.get(at + 2) == Some(&'\'') => quoted(c, at, '\''),
        _ => at,
    }
    .min(c.len())
}

fn follows_word(c: &[char], at: usize) -> bool {
    // `br"…"` is a raw string too.
    let before = at.checked_sub(1).map(|i| c[i]);
    before.is_some_and(|b| (b.is_alphanumeric() || b == '_') && b != 'b')
}

fn find(c: &[char], from: usize, text: &str) -> usize {
    let text: Vec<char> = text.chars().collect();
    (from..c.len())
        .find(|i| c[*i..].starts_with(&text))
        .unwrap_or(c.len())
}

fn quoted(c: &[char], at: usize, quote: char) -> usize {
    let mut i = at + 1;
    while i < c.len() && c[i] != quote {
        i += if c[i] == '\\' { 2 } else { 1 };
    }
    i + 1
}

fn raw_string(c: &[char], at: usize) -> usize {
    let hashes = c[at + 1..].iter().take_while(|h| **h == '#').count();
    if c.get(at + 1 + hashes) != Some(&'"') {
        return at; // a raw identifier
    }
    let close = format!("\"{}", "#".repeat(hashes));
    find(c, at + 2 + hashes, &close) + 1 + hashes
}

/// The part of a file that is built without tests: all before a test module, nothing of a file of tests.
pub(crate) fn without_tests<'a>(path: &str, source: &'a str) -> &'a str {
    if of_tests(path) {
        return "";
    }
    let test_module = source.match_indices("#[cfg(test)]").find(|(at, text)| {
        let rest = source[at + text.len()..].trim_start();
        rest.starts_with("mod ") || rest.starts_with("#[")
    });
    test_module.map_or(source, |(at, _)| &source[..at])
}

/// A file that only tests are built from.
pub(crate) fn of_tests(path: &str) -> bool {
    path.ends_with("tests.rs") || path.starts_with("tests/") || path.contains("/tests/")
}

/// Byte positions of `word` where it stands by itself.
pub(crate) fn words<'a>(code: &'a str, word: &'a str) -> impl Iterator<Item = usize> + 'a {
    let part = |c: char| c.is_alphanumeric() || c == '_';
    code.match_indices(word)
        .map(|(at, _)| at)
        .filter(move |at| {
            !code[..*at].ends_with(part) && !code[at + word.len()..].starts_with(part)
        })
}

/// Number of the line, from 1, that a byte position lies on.
pub(crate) fn line(code: &str, at: usize) -> usize {
    code[..at].matches('\n').count() + 1
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn comments_and_literals_are_blanked() {
        let source = "a // b\n/* c\n */ d \"e \\\" f\" g 'h' '\\'' r#\"i\" j\"# k<'l>(br\"m\")";
        let code = bare(source);
        assert_eq!(code.lines().count(), source.lines().count());
        let rest: String = code.split_whitespace().collect();
        assert_eq!(rest, "adgk<'l>(b)");
    }

    #[test]
    fn words_stand_by_themselves() {
        let found: Vec<usize> = words("unsafe unsafe_code not_unsafe (unsafe)", "unsafe").collect();
        assert_eq!(found, [0, 31]);
    }

    #[test]
    fn tests_are_left_out() {
        assert_eq!(
            without_tests("src/a.rs", "a\n#[cfg(test)]\nmod tests {}"),
            "a\n"
        );
        assert_eq!(
            without_tests("src/a.rs", "a\n#[cfg(test)]\nuse b;"),
            "a\n#[cfg(test)]\nuse b;"
        );
        for path in [
            "src/a/tests.rs",
            "src/a/heat_tests.rs",
            "tests/a.rs",
            "tools/cli/tests/a.rs",
        ] {
            assert_eq!(without_tests(path, "a"), "");
        }
    }
}
