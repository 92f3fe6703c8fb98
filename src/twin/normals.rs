//! Twin of `shaders/normals.comp`.

use glam::Vec3;

use super::{Args, shared::list};
use crate::pass::normals::Constants;

/// Area-weighted normals of all vertices.
pub fn run(args: &mut Args<'_>) {
    let c: Constants = args.constants();
    let (offsets, corners) = (args.read::<u32>(0), args.read::<u32>(1));
    let position = args.read::<[f32; 4]>(2);
    let normal = args.write::<[f32; 4]>(3);
    let at = |v: u32| Vec3::from_slice(&position[v as usize]);
    for v in 0..c.vertices {
        let x = at(v);
        let mut n = Vec3::ZERO;
        for pair in list::row(offsets, corners, v).chunks_exact(2) {
            n += (at(pair[0]) - x).cross(at(pair[1]) - x);
        }
        normal[v as usize] = (n / n.length().max(1e-30)).extend(0.0).to_array();
    }
}
