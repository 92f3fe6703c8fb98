//! Fleshing seen from outside: the paper's experiments.
#![allow(clippy::unwrap_used)]

mod common;
#[path = "../benches/flesh/table.rs"]
mod table;

use dermis::{
    asset,
    flesh::{
        BendOptions, Curve, INVALID, Map, Round, Spine, SpineDesc, bend, register, torn, volume,
    },
};
use glam::DVec3;

const MAPS: [Map; 3] = [Map::Radial, Map::Normal, Map::Binormal];

/// Table 1: plain skinning is off by 3 to 5 %, no map by more than 0.03 %.
#[test]
fn the_first_table_is_reproduced() {
    let lines = table::lines().unwrap();
    println!("{}", table::text(&lines));
    for line in &lines[1..3] {
        for error in [line.error, line.mesh_error] {
            assert!((-0.055..-0.025).contains(&error), "{}: {error}", line.name);
        }
    }
    for line in &lines[3..] {
        assert!(line.error.abs() < 1e-5, "{}: {}", line.name, line.error);
        assert!(
            line.mesh_error.abs() < 3e-4,
            "{}: {}",
            line.name,
            line.mesh_error
        );
    }
    assert_eq!(lines.len(), 9);
}

/// A spine along the longest side of a mesh, and the same bent to an arc of some degrees to the side.
fn along(positions: &[DVec3], degrees: f64) -> (Spine, Spine) {
    let low = positions.iter().copied().reduce(DVec3::min).unwrap();
    let high = positions.iter().copied().reduce(DVec3::max).unwrap();
    let (size, middle) = (high - low, 0.5 * (low + high));
    let axis = DVec3::AXES[size.max_position()];
    let side = DVec3::AXES[3 - size.max_position() - size.min_position()];
    let length = size.max_element();
    let start = middle - 0.5 * length * axis;
    let line = Curve::Polyline(vec![start, start + length * axis]);
    let rest = Spine::new(&SpineDesc::new(line)).unwrap();
    let arc = Curve::Arc(Round {
        start,
        tangent: axis,
        normal: side,
        radius: length / degrees.to_radians(),
        length,
    });
    let bent = Spine::like(&SpineDesc::new(arc), &rest).unwrap();
    (rest, bent)
}

/// Fig. 1: the volume of whole models. Their faces are as the files have them: what the maps do not keep is what straight edges
/// cut off.
#[test]
fn models_keep_their_volume() {
    let Some(data) = common::data() else { return };
    for name in [
        "static/libigl-tutorial/bunny.off",
        "static/libigl-tutorial/armadillo.obj",
        "static/common-3d/spot.obj",
    ] {
        let mesh = asset::load_surface(&data.join(name)).unwrap();
        let positions: Vec<DVec3> = mesh.positions.iter().map(|p| p.as_dvec3()).collect();
        let (rest, bent) = along(&positions, 40.0);
        let before = volume(&positions, &mesh.triangles);
        for map in MAPS {
            let registered = register(&rest, map, &positions, &[]).unwrap();
            assert_eq!(torn(&registered, &positions, &mesh.triangles), 0);
            let change = |strength| {
                let options = BendOptions {
                    strength,
                    ..BendOptions::default()
                };
                let there = bend(&registered, &bent, &options).unwrap();
                let invalid = there.flags.iter().filter(|f| *f & INVALID != 0).count();
                (
                    volume(&there.positions, &mesh.triangles) / before - 1.0,
                    invalid,
                )
            };
            let ((plain, _), (kept, invalid)) = (change(0.0), change(1.0));
            println!("{name} {map:?}: {plain:+.3e} plain, {kept:+.3e}, {invalid} invalid");
            assert_eq!(invalid, 0);
            assert!(kept.abs() < 5e-4, "{name} {map:?}: {kept}");
        }
    }
}
