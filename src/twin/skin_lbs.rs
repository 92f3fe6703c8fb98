//! Twin of `shaders/skin_lbs.comp`.

use glam::{Vec3, Vec4};

use super::{Args, skin_dqs::joint_at};
use crate::{
    layout::{JointPose, Vertex},
    pass::skin_lbs::Constants,
};

/// Skins every row.
pub fn run(args: &mut Args<'_>) {
    let c: Constants = args.constants();
    let vertex_of = args.read::<u32>(0);
    let row_normal = args.read::<[f32; 4]>(1);
    let vertices = args.read::<Vertex>(2);
    let joints = args.read::<u32>(3);
    let weights = args.read::<f32>(4);
    let palette = args.read::<JointPose>(5);
    let position = args.write::<[f32; 4]>(6);
    let normal = args.write::<[f32; 4]>(7);
    for row in 0..c.rows as usize {
        let v = vertex_of[row] as usize;
        let m = blend(v, c.width as usize, joints, weights, palette);
        let rest = Vec3::from_array(vertices[v].position);
        let p = Vec3::from_array(m.map(|r| r.truncate().dot(rest) + r.w));
        let [x, y, z] = m.map(Vec4::truncate);
        let rest_normal = Vec3::from_slice(&row_normal[row]);
        let n = Vec3::new(
            y.cross(z).dot(rest_normal),
            z.cross(x).dot(rest_normal),
            x.cross(y).dot(rest_normal),
        );
        position[row] = p.extend(0.0).to_array();
        normal[row] = (n / n.length().max(1e-20)).extend(0.0).to_array();
    }
}

/// Rows of the blended matrix.
fn blend(
    v: usize,
    width: usize,
    joints: &[u32],
    weights: &[f32],
    palette: &[JointPose],
) -> [Vec4; 3] {
    let mut rows = [Vec4::ZERO; 3];
    for at in v * width..(v + 1) * width {
        if weights[at] == 0.0 {
            break;
        }
        let joint = &palette[joint_at(joints, at)];
        for (row, add) in rows.iter_mut().zip(joint.rows) {
            *row += weights[at] * Vec4::from_array(add);
        }
    }
    rows
}
