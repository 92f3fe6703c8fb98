//! Spines and meshes along them: every function, as in `calls`, and that they give what Rust gives.
// Pointers are NULL or to what lives until the call returns.
#![allow(clippy::undocumented_unsafe_blocks)]

use std::{
    ffi::CString,
    ptr::{null, null_mut},
};

use dermis::{
    capi::{dm_result::*, *},
    flesh::{self, BendOptions, Curve, Map, Round, Spine, SpineDesc},
};
use glam::{DVec3, Vec3};

use crate::{
    calls::{
        Call,
        Takes::{Flesh, Nothing, Spine as TakesSpine},
        call, made,
    },
    fine, last_error, raw,
};

const LINE: [[f64; 3]; 2] = [[0.0; 3], [4.0, 0.0, 0.0]];

fn sized<T>() -> T {
    unsafe {
        let mut out: T = std::mem::zeroed();
        (&raw mut out).cast::<u32>().write(size_of::<T>() as u32);
        out
    }
}

fn line() -> dm_spine_desc {
    dm_spine_desc {
        kind: DM_SPINE_POLYLINE,
        point_count: 2,
        points: LINE.as_ptr().cast(),
        ..sized()
    }
}

fn arc() -> dm_spine_desc {
    dm_spine_desc {
        kind: DM_SPINE_ARC,
        tangent: [1.0, 0.0, 0.0],
        normal: [0.0, 1.0, 0.0],
        radius: 2.0,
        length: 4.0,
        ..sized()
    }
}

fn spine(desc: &dm_spine_desc, rest: dm_spine) -> dm_spine {
    let mut out = dm_spine::default();
    fine(unsafe { dm_spine_create(desc, rest, &mut out) });
    out
}

/// A straight spine and a tube that is registered on it.
pub(crate) fn make() -> (dm_spine, dm_flesh) {
    let spine = spine(&line(), dm_spine::default());
    let mesh = raw::Mesh::tube();
    let mut out = dm_flesh::default();
    fine(unsafe { dm_flesh_create(spine, &registered(&mesh), &mut out) });
    (spine, out)
}

fn registered(mesh: &raw::Mesh) -> dm_flesh_desc {
    dm_flesh_desc {
        vertices: mesh.positions.len() as u32,
        positions: mesh.positions.as_ptr().cast(),
        normals: mesh.positions.as_ptr().cast(),
        ..sized()
    }
}

/// A spine's file, and the folder that it is in.
fn file() -> (tempfile::TempDir, CString) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("spine.json");
    std::fs::write(
        &path,
        r#"{"kind": "bspline", "points": [[0, 0, 0], [1, 2, 3]]}"#,
    )
    .unwrap();
    let path = CString::new(path.to_str().unwrap()).unwrap();
    (folder, path)
}

#[rustfmt::skip]
pub(crate) const FLESH_CALLS: &[Call] = &[
    call("dm_spine_create", Nothing, true, true, |a| unsafe {
        let mut desc = dm_spine_desc { size: a.size::<dm_spine_desc>(), ..line() };
        desc.points = a.of(desc.points.cast_mut());
        let profile = [0.0, 0.0, 1.0, 90.0];
        (desc.profile_count, desc.twist_profile) = (2, a.from(&profile));
        let mut out = dm_spine::default();
        let result = dm_spine_create(a.of(&mut desc), a.spine, a.of(&mut out));
        made(result, || dm_spine_destroy(out))
    }),
    call("dm_spine_load", Nothing, true, false, |a| unsafe {
        let (_folder, path) = file();
        let mut out = dm_spine::default();
        let result = dm_spine_load(a.text(&path), a.spine, a.of(&mut out));
        made(result, || dm_spine_destroy(out))
    }),
    call("dm_spine_destroy", TakesSpine, false, false, |a| dm_spine_destroy(a.spine)),
    call("dm_spine_get_info", TakesSpine, true, true, |a| unsafe {
        let mut out = dm_spine_info { size: a.size::<dm_spine_info>(), ..sized() };
        dm_spine_get_info(a.spine, a.of(&mut out))
    }),
    call("dm_spine_at", TakesSpine, true, true, |a| unsafe {
        let mut out = dm_spine_section { size: a.size::<dm_spine_section>(), ..sized() };
        dm_spine_at(a.spine, 1.0, a.of(&mut out))
    }),
    call("dm_flesh_create", TakesSpine, true, true, |a| unsafe {
        let mesh = raw::Mesh::tube();
        let mut desc = dm_flesh_desc { size: a.size::<dm_flesh_desc>(), ..registered(&mesh) };
        desc.positions = a.of(desc.positions.cast_mut());
        desc.normals = a.may(desc.normals.cast_mut());
        let mut out = dm_flesh::default();
        let result = dm_flesh_create(a.spine, a.of(&mut desc), a.of(&mut out));
        made(result, || dm_flesh_destroy(out))
    }),
    call("dm_flesh_destroy", Flesh, false, false, |a| dm_flesh_destroy(a.flesh)),
    call("dm_flesh_bend", Flesh, true, true, |a| unsafe {
        let count = raw::Mesh::tube().positions.len();
        let mut vectors = [vec![0f32; 3 * count], vec![0f32; 3 * count]];
        let (mut distances, mut flags) = (vec![0f32; count], vec![0u32; count]);
        let mut options = dm_flesh_options { size: a.size::<dm_flesh_options>(), ..options() };
        let mut out = dm_bent {
            size: a.size::<dm_bent>(),
            vertices: count as u32,
            positions: a.may(vectors[0].as_mut_ptr()),
            normals: a.may(vectors[1].as_mut_ptr()),
            distances: a.may(distances.as_mut_ptr()),
            flags: a.may(flags.as_mut_ptr()),
        };
        dm_flesh_bend(a.flesh, a.spine, a.may(&mut options), a.of(&mut out))
    }),
];

fn options() -> dm_flesh_options {
    dm_flesh_options {
        strength: 1.0,
        ..sized()
    }
}

#[test]
fn a_mesh_is_bent_as_by_rust() {
    let (rest, flesh) = make();
    let mut desc = arc();
    let profile = [0.0, 0.0, 1.0, 90.0];
    (desc.profile_count, desc.twist_profile) = (2, profile.as_ptr());
    let bent = spine(&desc, rest);
    let mesh = raw::Mesh::tube();
    let count = mesh.positions.len();
    let mut positions = vec![Vec3::ZERO; count];
    let mut normals = vec![Vec3::ZERO; count];
    let (mut distances, mut flags) = (vec![0f32; count], vec![9u32; count]);
    let out = dm_bent {
        vertices: count as u32,
        positions: positions.as_mut_ptr().cast(),
        normals: normals.as_mut_ptr().cast(),
        distances: distances.as_mut_ptr(),
        flags: flags.as_mut_ptr(),
        ..sized()
    };
    fine(unsafe { dm_flesh_bend(flesh, bent, null(), &out) });
    let line = Curve::Polyline(LINE.map(DVec3::from_array).to_vec());
    let rust_rest = Spine::new(&SpineDesc::new(line)).unwrap();
    let mut rust = SpineDesc::new(Curve::Arc(Round {
        start: DVec3::ZERO,
        tangent: DVec3::X,
        normal: DVec3::Y,
        radius: 2.0,
        length: 4.0,
    }));
    rust.twist.profile = vec![[0.0, 0.0], [1.0, 90.0]];
    let rust_bent = Spine::like(&rust, &rust_rest).unwrap();
    let rows: Vec<DVec3> = mesh
        .positions
        .iter()
        .map(|p| Vec3::from_array(*p).as_dvec3())
        .collect();
    let registered = flesh::register(&rust_rest, Map::Radial, &rows, &rows).unwrap();
    let wanted = flesh::bend(&registered, &rust_bent, &BendOptions::default()).unwrap();
    for row in 0..count {
        assert_eq!(positions[row], wanted.positions[row].as_vec3());
        assert_eq!(normals[row], wanted.normals[row].as_vec3());
        assert_eq!(distances[row], wanted.distances[row] as f32);
    }
    assert_eq!(flags, wanted.flags);
    let mut section = sized::<dm_spine_section>();
    fine(unsafe { dm_spine_at(bent, 4.0, &mut section) });
    assert_eq!(section.position, rust_bent.section(4.0).position.to_array());
    let mut info = sized::<dm_spine_info>();
    fine(unsafe { dm_spine_get_info(bent, &mut info) });
    assert_eq!((info.closed, info.length), (0, rust_bent.length()));
    for handle in [rest, bent] {
        fine(dm_spine_destroy(handle));
    }
    fine(dm_flesh_destroy(flesh));
}

#[test]
fn what_is_wrong_with_spines_and_meshes_is_named() {
    let refuse = |result: dm_result, wanted: dm_result, named: &str| {
        assert_eq!(result, wanted, "{}", last_error());
        assert!(last_error().contains(named), "{named}: {}", last_error());
    };
    let none = dm_spine::default();
    let create =
        |desc: dm_spine_desc| unsafe { dm_spine_create(&desc, none, &mut dm_spine::default()) };
    let wrong: [(dm_spine_desc, &str); 8] = [
        (dm_spine_desc { kind: 9, ..line() }, "desc.kind"),
        (
            dm_spine_desc {
                point_count: 1,
                ..line()
            },
            "points",
        ),
        (
            dm_spine_desc {
                point_count: !0,
                ..line()
            },
            "desc.points",
        ),
        (
            dm_spine_desc {
                radius: f64::NAN,
                ..arc()
            },
            "radius",
        ),
        (
            dm_spine_desc {
                length: 0.0,
                ..arc()
            },
            "length",
        ),
        (
            dm_spine_desc {
                up: [f64::NAN; 3],
                ..arc()
            },
            "up",
        ),
        (
            dm_spine_desc {
                ease: f64::NAN,
                ..arc()
            },
            "ease",
        ),
        (
            dm_spine_desc {
                twist_degrees: f64::INFINITY,
                ..arc()
            },
            "twist",
        ),
    ];
    for (desc, named) in wrong {
        refuse(create(desc), DM_ERROR_ARGUMENT, named);
    }
    fine(create(dm_spine_desc {
        ease: -1.0,
        ..arc()
    }));
    let missing = c"no/spine.json".as_ptr();
    let load = unsafe { dm_spine_load(missing, none, &mut dm_spine::default()) };
    refuse(load, DM_ERROR_FILE, "no/spine.json");
    let (rest, flesh) = make();
    let at = unsafe { dm_spine_at(rest, f64::NAN, &mut sized()) };
    refuse(at, DM_ERROR_ARGUMENT, "arc_length");
    let mut mesh = raw::Mesh::tube();
    let register =
        |desc: dm_flesh_desc| unsafe { dm_flesh_create(rest, &desc, &mut dm_flesh::default()) };
    let desc = registered(&mesh);
    refuse(
        register(dm_flesh_desc { map: 3, ..desc }),
        DM_ERROR_ARGUMENT,
        "desc.map",
    );
    refuse(
        register(dm_flesh_desc {
            vertices: 0,
            ..desc
        }),
        DM_ERROR_ARGUMENT,
        "desc.vertices",
    );
    refuse(
        register(dm_flesh_desc {
            vertices: !0,
            ..desc
        }),
        DM_ERROR_ARGUMENT,
        "desc.vertices",
    );
    mesh.positions[7][1] = f32::NAN;
    refuse(
        register(registered(&mesh)),
        DM_ERROR_ARGUMENT,
        "positions/7",
    );
    let out = dm_bent {
        vertices: mesh.positions.len() as u32,
        ..sized()
    };
    let bend = |options: dm_flesh_options, out: dm_bent| unsafe {
        dm_flesh_bend(flesh, rest, &options, &out)
    };
    refuse(
        bend(options(), dm_bent { vertices: 3, ..out }),
        DM_ERROR_SIZE,
        "out.vertices",
    );
    let strong = dm_flesh_options {
        strength: 2.0,
        ..options()
    };
    refuse(bend(strong, out), DM_ERROR_ARGUMENT, "strength");
    fine(bend(options(), out));
    let bare = dm_flesh_desc {
        normals: null(),
        ..desc
    };
    let mut plain = dm_flesh::default();
    mesh.positions[7][1] = 0.0;
    fine(unsafe { dm_flesh_create(rest, &bare, &mut plain) });
    let mut normals = vec![0f32; 3 * mesh.positions.len()];
    let with = dm_bent {
        normals: normals.as_mut_ptr(),
        ..out
    };
    refuse(
        unsafe { dm_flesh_bend(plain, rest, null(), &with) },
        DM_ERROR_ARGUMENT,
        "out.normals",
    );
    fine(unsafe {
        dm_flesh_bend(
            plain,
            rest,
            null(),
            &dm_bent {
                normals: null_mut(),
                ..out
            },
        )
    });
    for handle in [flesh, plain] {
        fine(dm_flesh_destroy(handle));
    }
    fine(dm_spine_destroy(rest));
}
