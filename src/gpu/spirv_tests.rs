use super::*;

fn reflected(bytes: &[u8]) -> Reflection {
    reflect(&words(bytes).unwrap()).unwrap()
}

fn binding(binding: u32, kind: Kind, readonly: bool, writeonly: bool) -> Reflected {
    Reflected {
        set: 0,
        binding,
        kind,
        readonly,
        writeonly,
    }
}

#[test]
fn storage_buffers_with_their_qualifiers() {
    let add = reflected(include_bytes!("testdata/add.spv"));
    let expected = [
        binding(0, Kind::Storage, true, false),
        binding(1, Kind::Storage, false, true),
    ];
    assert_eq!(add.bindings, expected);
    assert_eq!((add.constants, add.local_size), (8, [64, 1, 1]));
    assert_eq!(add.entry, "main");
    let double = reflected(include_bytes!("testdata/double.spv"));
    assert_eq!(double.bindings, [binding(0, Kind::Storage, false, false)]);
    assert_eq!(double.constants, 0);
}

#[test]
fn uniform_buffers_and_images() {
    let extent = reflected(include_bytes!("testdata/extent.spv"));
    assert_eq!(extent.bindings[0].kind, Kind::Uniform);
    let paint = reflected(include_bytes!("testdata/paint.spv"));
    let (volume, format) = (true, Some(Format::Rgba16F));
    let expected = binding(0, Kind::Image { volume, format }, false, true);
    assert_eq!(paint.bindings, [expected]);
    assert_eq!(paint.local_size, [4, 4, 4]);
    let sample = reflected(include_bytes!("testdata/sample.spv"));
    assert_eq!(sample.bindings[0].kind, Kind::Sampled { volume });
    let texels = reflected(include_bytes!("testdata/texels.spv"));
    assert_eq!(texels.bindings[0].kind, Kind::Texels);
    let words = reflected(include_bytes!("testdata/words.spv"));
    assert_eq!(words.bindings[0].kind, Kind::Words);
}

#[test]
fn sizes_follow_the_layout_and_other_sets_are_seen() {
    let layouts = reflected(include_bytes!("testdata/layouts.spv"));
    // mat4 at 0, vec3 at 64, float at 76, two of { vec2, float } with stride 16 at 80, uint at 112.
    assert_eq!(layouts.constants, 116);
    assert_eq!(layouts.local_size, [2, 3, 5]);
    let found = (layouts.bindings[0].set, layouts.bindings[0].binding);
    assert_eq!(found, (1, 7));
}

#[test]
fn what_is_no_compute_shader_is_refused() {
    assert!(words(&[1, 2, 3]).is_err());
    assert!(reflect(&[]).is_err());
    assert!(reflect(&[MAGIC, 0, 0, 0, 0]).is_err());
    assert!(reflect(&[1, 2, 3, 4, 5, 6]).is_err());
}

#[test]
fn every_cut_and_every_changed_word_ends_in_an_answer() {
    let good = words(include_bytes!("testdata/layouts.spv")).unwrap();
    let mut refused = 0;
    for row in 0..good.len() {
        refused += usize::from(reflect(&good[..row]).is_err());
        for value in [
            0,
            1,
            u32::MAX,
            good[row].wrapping_add(1),
            good[row] ^ 0x0001_0000,
        ] {
            let mut bad = good.clone();
            bad[row] = value;
            let _ = reflect(&bad);
        }
    }
    assert!(refused > good.len() / 2);
}
