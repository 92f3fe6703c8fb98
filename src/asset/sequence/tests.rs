#![allow(clippy::unwrap_used)]

use super::*;

const ROOM: Room = Room {
    bytes: 1 << 20,
    need: |frames| 12 * frames as u64,
};

fn npy(shape: &str, count: usize) -> Vec<u8> {
    let text = format!("{{'descr': '<f4', 'fortran_order': False, 'shape': {shape}, }}\n");
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend((text.len() as u16).to_le_bytes());
    bytes.extend(text.as_bytes());
    bytes.extend((0..count).flat_map(|i| (i as f32).to_le_bytes()));
    bytes
}

fn folder() -> tempfile::TempDir {
    let dir = tempfile::tempdir().unwrap();
    let rest = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    fs::write(dir.path().join("rest.obj"), rest).unwrap();
    fs::write(dir.path().join("frames.npy"), npy("(2, 3, 3)", 18)).unwrap();
    dir
}

fn refusal(dir: &tempfile::TempDir) -> String {
    load_sequence(dir.path(), ROOM).unwrap_err().to_string()
}

#[test]
fn an_array_is_read_frame_by_frame() {
    let dir = folder();
    let sequence = load_sequence(dir.path(), ROOM).unwrap();
    assert_eq!(sequence.frames.len(), 2);
    assert_eq!(sequence.frames[1][2], Vec3::new(15.0, 16.0, 17.0));
    assert_eq!(sequence.triangles, [[0, 1, 2]]);
}

#[test]
fn what_does_not_fit_is_refused_before_it_is_read() {
    let dir = folder();
    let small = Room {
        bytes: 71,
        need: |frames| 12 * frames as u64,
    };
    let error = load_sequence(dir.path(), small).unwrap_err().to_string();
    for word in ["72 bytes", "3 vertices in 2 frames", "71 bytes"] {
        assert!(error.contains(word), "{error}");
    }
    // The numbers of the array are never looked at: they would be refused.
    let mut bad = npy("(2, 3, 3)", 17);
    bad.extend(f32::NAN.to_le_bytes());
    fs::write(dir.path().join("frames.npy"), bad).unwrap();
    let error = load_sequence(dir.path(), small).unwrap_err();
    assert!(matches!(error, Error::Memory { bytes: 72, .. }), "{error}");
    assert!(refusal(&dir).contains("frame 1, vertex 2"));
}

#[test]
fn a_damaged_array_is_refused() {
    for (bytes, word) in [
        (npy("(2, 3, 3)", 17), "bytes"),
        (npy("(2, 4, 3)", 24), "4 vertices"),
        (npy("(2, 3, 4)", 24), "shape"),
        (npy("(0, 3, 3)", 0), "shape"),
        (npy("(99999999999, 3, 3)", 18), "bytes"),
        (npy("(2, 3, 3)", 18)[..40].to_vec(), "ends within"),
        (b"\x93NUMPY".to_vec(), "version"),
        (Vec::new(), "no NumPy"),
    ] {
        let dir = folder();
        fs::write(dir.path().join("frames.npy"), bytes).unwrap();
        let error = refusal(&dir);
        assert!(
            error.contains("frames.npy") && error.contains(word),
            "{word}: {error}"
        );
    }
    let dir = folder();
    for (from, to) in [("<f4", "<f8"), ("False", "True ")] {
        let text = String::from_utf8_lossy(&npy("(1, 3, 3)", 0)).replace(from, to);
        let mut bytes = npy("(1, 3, 3)", 9);
        let at = bytes.windows(from.len()).position(|w| w == from.as_bytes());
        bytes[at.unwrap()..][..from.len()].copy_from_slice(&to.as_bytes()[..from.len()]);
        fs::write(dir.path().join("frames.npy"), bytes).unwrap();
        assert!(refusal(&dir).contains("header"), "{text}");
    }
    fs::remove_file(dir.path().join("rest.obj")).unwrap();
    assert!(refusal(&dir).contains("rest.obj"));
}

#[test]
fn meshes_come_in_the_order_of_their_numbers_and_are_compared() {
    let dir = tempfile::tempdir().unwrap();
    let mesh = |x: i32| format!("v {x} 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    for x in [9, 10, 8] {
        fs::write(dir.path().join(format!("horse_{x}.obj")), mesh(x)).unwrap();
    }
    fs::write(dir.path().join("readme.txt"), "").unwrap();
    let sequence = load_sequence(dir.path(), ROOM).unwrap();
    let first: Vec<f32> = sequence.frames.iter().map(|f| f[0].x).collect();
    assert_eq!(first, [8.0, 9.0, 10.0]);
    for (text, word) in [
        (mesh(1) + "v 0 0 1\n", "4, but the first frame has 3"),
        (mesh(1) + "f 1 2 3\n", "2, but the first frame has 1"),
        (mesh(1).replace("f 1 2 3", "f 1 3 2"), "triangle 0"),
        (mesh(1).replace("v 1", "v nan"), "line 1"),
        (String::new(), "no faces"),
    ] {
        fs::write(dir.path().join("horse_9.obj"), text).unwrap();
        let error = refusal(&dir);
        assert!(
            error.contains("horse_9.obj") && error.contains(word),
            "{word}: {error}"
        );
    }
    let one = load_sequence(&dir.path().join("horse_8.obj"), ROOM).unwrap();
    assert_eq!(one.frames.len(), 1);
    assert!(refusal(&tempfile::tempdir().unwrap()).contains("frames.npy"));
}

#[test]
fn names_are_ordered_as_people_count() {
    for (a, b) in [
        ("f2", "f10"),
        ("f010", "f11"),
        ("a", "b"),
        ("f", "f1"),
        ("1b", "02a"),
    ] {
        assert_eq!(natural(a, b), Ordering::Less, "{a} {b}");
    }
}

#[test]
fn what_is_named_like_a_frame_but_is_no_file_is_refused() {
    let dir = folder();
    fs::remove_file(dir.path().join("frames.npy")).unwrap();
    assert_eq!(load_sequence(dir.path(), ROOM).unwrap().frames.len(), 1);
    for name in ["s.obj", "frames.npy"] {
        let path = dir.path().join(name);
        fs::create_dir(&path).unwrap();
        let error = refusal(&dir);
        assert!(
            error.contains(name) && error.contains("it is a folder"),
            "{error}"
        );
        fs::remove_dir(&path).unwrap();
    }
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink("missing", dir.path().join("t.ply")).unwrap();
        let error = refusal(&dir);
        assert!(error.contains("t.ply"), "{error}");
    }
}
