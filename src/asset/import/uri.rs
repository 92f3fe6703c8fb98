//! URIs of buffers: data URIs (RFC 2397) and files in the folder of the glTF file.

use std::path::{Component, Path};

use super::{
    container,
    fault::{Checked, Fault, refuse},
};

/// Bytes behind `uri`; a relative path never leaves `folder`.
pub(super) fn resolve(uri: &str, folder: &Path, element: &str) -> Checked<Vec<u8>> {
    if let Some(rest) = strip_scheme(uri, "data:") {
        return data(rest).map_err(|reason| Fault::new(element, reason));
    }
    if has_scheme(uri) {
        return refuse(element, "only data URIs and relative paths are read");
    }
    let path = percent_decode(uri)
        .and_then(|bytes| String::from_utf8(bytes).ok())
        .ok_or_else(|| Fault::new(element, "not a valid URI"))?;
    file(Path::new(&path), folder)
        .map_err(|reason| Fault::new(element, format!("{path}: {reason}")))
}

fn strip_scheme<'a>(uri: &'a str, scheme: &str) -> Option<&'a str> {
    let head = uri.get(..scheme.len())?;
    head.eq_ignore_ascii_case(scheme)
        .then(|| &uri[scheme.len()..])
}

/// RFC 3986: letters, digits, `+`, `-`, `.` before the first colon, which comes before any slash.
fn has_scheme(uri: &str) -> bool {
    uri.split_once(':').is_some_and(|(scheme, _)| {
        scheme
            .bytes()
            .all(|byte| byte.is_ascii_alphanumeric() || b"+-.".contains(&byte))
    })
}

fn data(rest: &str) -> Result<Vec<u8>, &'static str> {
    let (header, body) = rest.split_once(',').ok_or("a data URI without a comma")?;
    let encoded = header.to_ascii_lowercase().ends_with(";base64");
    if encoded && !body.contains('%') {
        return base64(body.as_bytes());
    }
    let body = percent_decode(body).ok_or("not a valid URI")?;
    if encoded { base64(&body) } else { Ok(body) }
}

/// Standard alphabet, padding optional (RFC 4648).
fn base64(text: &[u8]) -> Result<Vec<u8>, &'static str> {
    const WRONG: &str = "not valid base64";
    let end = text.iter().rposition(|&c| c != b'=').map_or(0, |i| i + 1);
    let (text, padding) = text.split_at(end);
    if padding.len() > 2 || text.len() % 4 == 1 {
        return Err(WRONG);
    }
    let mut bytes = Vec::with_capacity(text.len() / 4 * 3 + 2);
    for group in text.chunks(4) {
        let mut word = 0_u32;
        for &character in group {
            word = word << 6 | sextet(character).ok_or(WRONG)?;
        }
        word <<= 6 * (4 - group.len());
        bytes.extend_from_slice(&word.to_be_bytes()[1..group.len()]);
    }
    Ok(bytes)
}

fn sextet(character: u8) -> Option<u32> {
    let value = match character {
        b'A'..=b'Z' => character - b'A',
        b'a'..=b'z' => character - b'a' + 26,
        b'0'..=b'9' => character - b'0' + 52,
        b'+' => 62,
        b'/' => 63,
        _ => return None,
    };
    Some(value.into())
}

fn percent_decode(text: &str) -> Option<Vec<u8>> {
    let mut bytes = text.bytes();
    let mut decoded = Vec::with_capacity(text.len());
    while let Some(byte) = bytes.next() {
        if byte != b'%' {
            decoded.push(byte);
            continue;
        }
        let high = char::from(bytes.next()?).to_digit(16)?;
        let low = char::from(bytes.next()?).to_digit(16)?;
        decoded.push((high * 16 + low) as u8);
    }
    Some(decoded)
}

fn file(relative: &Path, folder: &Path) -> Result<Vec<u8>, String> {
    let plain = |c| matches!(c, Component::Normal(_) | Component::CurDir);
    let text = relative.as_os_str().as_encoded_bytes();
    if text.is_empty() || text.contains(&0) || text.contains(&b'\\') {
        return Err("not a relative path".into());
    }
    if !relative.components().all(plain) {
        return Err("leaves the folder of the file".into());
    }
    let text = |error: std::io::Error| error.to_string();
    // A link inside the folder must not lead out of it either.
    let folder = folder.canonicalize().map_err(text)?;
    let path = folder.join(relative).canonicalize().map_err(text)?;
    if !path.starts_with(&folder) {
        return Err("leaves the folder of the file".into());
    }
    container::read(&path).map_err(text)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn base64_matches_the_vectors_of_rfc_4648() {
        let vectors = [
            ("", ""),
            ("Zg==", "f"),
            ("Zm8=", "fo"),
            ("Zm9v", "foo"),
            ("Zm9vYg==", "foob"),
            ("Zm9vYmE", "fooba"),
        ];
        for (text, plain) in vectors {
            assert_eq!(base64(text.as_bytes()).unwrap(), plain.as_bytes());
        }
        for wrong in ["Z", "Zm9v!", "Zg===", "Z=g="] {
            assert!(base64(wrong.as_bytes()).is_err(), "{wrong}");
        }
    }

    #[test]
    fn a_path_never_leaves_the_folder() {
        let outer = tempfile::tempdir().unwrap();
        let inner = outer.path().join("inner");
        std::fs::create_dir(&inner).unwrap();
        std::fs::write(outer.path().join("secret"), b"no").unwrap();
        std::fs::write(inner.join("a b.bin"), b"yes").unwrap();
        assert_eq!(resolve("a%20b.bin", &inner, "/").unwrap(), b"yes");
        assert_eq!(resolve("./a b.bin", &inner, "/").unwrap(), b"yes");
        let absolute = outer.path().join("secret");
        for wrong in [
            "../secret",
            "%2e%2e/secret",
            "..\\secret",
            absolute.to_str().unwrap(),
            "file:///etc/hostname",
            "missing.bin",
            "%zz",
            "",
        ] {
            assert!(resolve(wrong, &inner, "/").is_err(), "{wrong}");
        }
    }

    #[cfg(unix)]
    #[test]
    fn a_link_never_leaves_the_folder() {
        let outer = tempfile::tempdir().unwrap();
        let inner = outer.path().join("inner");
        std::fs::create_dir(&inner).unwrap();
        std::fs::write(outer.path().join("secret"), b"no").unwrap();
        std::os::unix::fs::symlink("../secret", inner.join("link")).unwrap();
        assert!(resolve("link", &inner, "/").is_err());
    }
}
