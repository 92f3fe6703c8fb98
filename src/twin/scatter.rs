//! Twin of `shaders/scatter.comp`.

use glam::{Vec3, Vec4};

use super::{
    Args,
    shared::rotation::{rotate, rotate_between},
};
use crate::{layout::Vertex, pass::scatter::Constants};

/// Copies welded positions to the file's rows and turns the rows' normals.
pub fn run(args: &mut Args<'_>) {
    let c: Constants = args.constants();
    let vertex_of = args.read::<u32>(0);
    let row_normal = args.read::<[f32; 4]>(1);
    let vertices = args.read::<Vertex>(2);
    let rotation = args.read::<[f32; 4]>(3);
    let position = args.read::<[f32; 4]>(4);
    let smooth_normal = args.read::<[f32; 4]>(5);
    let skin_position = args.write::<[f32; 4]>(6);
    let skin_normal = args.write::<[f32; 4]>(7);
    for row in 0..c.rows as usize {
        let v = vertex_of[row] as usize;
        let q = Vec4::from_array(rotation[v]);
        let n = rotate(q, Vec3::from_slice(&row_normal[row]));
        let turned = rotate(q, Vec3::from_array(vertices[v].normal));
        let n = rotate_between(turned, Vec3::from_slice(&smooth_normal[v]), n);
        skin_position[row] = position[v];
        skin_normal[row] = (n / n.length().max(1e-20)).extend(0.0).to_array();
    }
}
