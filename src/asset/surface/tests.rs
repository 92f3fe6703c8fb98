#![allow(clippy::unwrap_used)]

use super::*;

const OBJ: &str =
    "# a quad\nmtllib x.mtl\nv 0 0 0\nv 1 0 0 1 0 0\nv 1 1 0\nv 0 1 0\nf 1/1 2/2/2 3//3 \\\n -1\n";
const OFF: &str = "OFF # head\n4 1 0\n\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3 255 0 0\n";
const HEAD: &str = "element vertex 4\nproperty double x\nproperty float y\nproperty uchar tag\n\
    property list uchar short extra\nproperty float z\nelement edge 1\nproperty int a\nelement face 1\n\
    property list uchar int vertex_indices\nelement nothing 99999999999\nend_header\n";

fn quad() -> Surface {
    Surface {
        positions: [[0., 0., 0.], [1., 0., 0.], [1., 1., 0.], [0., 1., 0.]]
            .map(Vec3::from)
            .to_vec(),
        triangles: vec![[0, 1, 2], [0, 2, 3]],
    }
}

fn text_ply() -> String {
    let body = "0 0 7 0 0\n1 0 7 1 5 0\n1 1 7 0 0\n0 1 7 2 1 2 0\n3\n4 0 1 2 3\n";
    format!("ply\nformat ascii 1.0\ncomment é\n{HEAD}{body}")
}

fn binary_ply(big: bool) -> Vec<u8> {
    let name = if big { "big" } else { "little" };
    let mut bytes = format!("ply\nformat binary_{name}_endian 1.0\n{HEAD}").into_bytes();
    let mut put = |value: &[u8]| {
        let mut value = value.to_vec();
        if big {
            value.reverse();
        }
        bytes.extend(value);
    };
    for p in quad().positions {
        put(&f64::from(p.x).to_le_bytes());
        put(&p.y.to_le_bytes());
        put(&[7]);
        put(&[1]);
        put(&5i16.to_le_bytes());
        put(&p.z.to_le_bytes());
    }
    put(&3i32.to_le_bytes());
    put(&[4]);
    for i in 0..4i32 {
        put(&i.to_le_bytes());
    }
    bytes
}

fn obj_refusal(text: &str) -> (String, String) {
    obj::parse(text.as_bytes()).unwrap_err()
}

#[test]
fn every_format_gives_the_same_quad() {
    assert_eq!(obj::parse(OBJ.as_bytes()).unwrap(), quad());
    assert_eq!(off::parse(OFF.as_bytes()).unwrap(), quad());
    let one_line = OFF.replace("OFF # head\n", "COFF ");
    assert_eq!(off::parse(one_line.as_bytes()).unwrap(), quad());
    assert_eq!(ply::parse(text_ply().as_bytes()).unwrap(), quad());
    assert_eq!(ply::parse(&binary_ply(false)).unwrap(), quad());
    assert_eq!(ply::parse(&binary_ply(true)).unwrap(), quad());
}

#[test]
fn windows_line_ends_are_read() {
    let obj = OBJ.replace('\n', "\r\n");
    assert_eq!(obj::parse(obj.as_bytes()).unwrap(), quad());
    let ply = text_ply().replace('\n', "\r\n");
    assert_eq!(ply::parse(ply.as_bytes()).unwrap(), quad());
}

#[test]
fn a_truncated_file_is_refused_or_shorter_but_never_a_panic() {
    for k in 0..OFF.trim_end().len() - 10 {
        assert!(off::parse(&OFF.as_bytes()[..k]).is_err(), "{k}");
    }
    let text = text_ply();
    for k in 0..text.trim_end().len() {
        assert!(ply::parse(&text.as_bytes()[..k]).is_err(), "{k}");
    }
    for big in [false, true] {
        let bytes = binary_ply(big);
        for k in 0..bytes.len() {
            let (element, _) = ply::parse(&bytes[..k]).unwrap_err();
            assert!(!element.is_empty(), "{k}");
        }
    }
    for k in 0..OBJ.len() {
        let _ = obj::parse(&OBJ.as_bytes()[..k]);
    }
    let (element, reason) =
        ply::parse(&binary_ply(false)[..binary_ply(false).len() - 1]).unwrap_err();
    assert_eq!(
        (element.as_str(), reason.as_str()),
        ("face 0", "the file ends within it")
    );
}

#[test]
fn obj_refusals_name_the_line() {
    for (text, line, word) in [
        ("v 0 0\n", "line 1", "missing"),
        ("\nv 0 0 x\n", "line 2", "\"x\""),
        ("v 0 nan 0\n", "line 1", "not finite"),
        ("v 0 1e39 0\n", "line 1", "not finite"),
        ("v 0 0 0\nf 1 2 3\n", "line 2", "vertex 2"),
        ("v 0 0 0\nf 1 1 -2\n", "line 2", "-2"),
        ("v 0 0 0\nf 0 1 1\n", "line 2", "\"0\""),
        ("v 0 0 0\nf 1 1\n", "line 2", "2 corners"),
        ("v 0 0 0\nf 1 1 99999999999999999999\n", "line 2", "corner"),
        ("v 0 0 0\n", "file", "no faces"),
        ("", "file", "no faces"),
    ] {
        let (element, reason) = obj_refusal(text);
        assert_eq!(element, line, "{text:?}: {reason}");
        assert!(reason.contains(word), "{text:?}: {reason}");
    }
}

#[test]
fn ply_and_off_refusals_name_the_place() {
    let ply =
        |from: &str, to: &str| ply::parse(text_ply().replace(from, to).as_bytes()).unwrap_err();
    for (from, to, place, word) in [
        ("ply\n", "plx\n", "line 1", "ply"),
        ("ascii", "esoteric", "line 2", "esoteric"),
        ("format ascii 1.0\n", "", "header", "format"),
        ("vertex 4", "vertex -4", "line 4", "-4"),
        ("uchar tag", "quad tag", "line 7", "quad"),
        ("double x", "double u", "header", "property x"),
        ("vertex_indices", "corners", "header", "vertex_indices"),
        ("uchar short extra", "float short extra", "line 8", "whole"),
        ("end_header", "ende", "line 15", "ende"),
        ("4 0 1 2 3", "4 0 1 2 4", "face 0", "vertex 4"),
        ("4 0 1 2 3", "4 0 1 2 -1", "line 21", "-1"),
        ("4 0 1 2 3", "4 0 1 2 0.5", "line 21", "0.5"),
        ("4 0 1 2 3", "2 0 1", "line 21", "2 corners"),
        ("4 0 1 2 3", "-4 0 1 2 3", "line 21", "list of -4"),
        ("1 1 7 0 0", "1 inf 7 0 0", "line 18", "not finite"),
        ("1 1 7 0 0", "1 1 seven 0 0", "line 18", "seven"),
        ("4 0 1 2 3", "4000000000 0 1 2 3", "end of file", "early"),
        ("vertex 4", "vertex 40000000000", "end of file", "early"),
    ] {
        let (element, reason) = ply(from, to);
        assert!(element.starts_with(place), "{to:?}: {element}: {reason}");
        assert!(reason.contains(word), "{to:?}: {element}: {reason}");
    }
    for (from, to, place) in [
        ("OFF", "4OFF", "line 1"),
        ("OFF", "OFF BINARY", "line 1"),
        ("4 1 0", "4 x 0", "line 2"),
        ("4 0 1 2 3", "4 0 1 2 9", "line 8"),
        ("4 0 1 2 3", "9 0 1 2 3", "line 8"),
        ("4 1 0", "5 1 0", "end of file"),
        ("4 1 0", "4 99999999999999 0", "end of file"),
    ] {
        let (element, reason) = off::parse(OFF.replacen(from, to, 1).as_bytes()).unwrap_err();
        assert_eq!(element, place, "{to:?}: {reason}");
    }
}

#[test]
fn the_file_is_named() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("Quad.OBJ");
    fs::write(&path, OBJ).unwrap();
    assert_eq!(load_surface(&path).unwrap(), quad());
    assert!(is_surface(&path));
    fs::write(&path, "v 0 0 0\nf 1 2 3\n").unwrap();
    let error = load_surface(&path).unwrap_err().to_string();
    assert!(error.contains("Quad.OBJ: line 2: "), "{error}");
    let error = load_surface(&dir.path().join("missing.off")).unwrap_err();
    assert!(matches!(error, Error::File { .. }));
    let error = load_surface(&dir.path().join("mesh.stl"))
        .unwrap_err()
        .to_string();
    assert!(error.contains("mesh.stl"), "{error}");
}
