//! Twin of `shaders/skin_dqs.comp`.

use glam::{Mat3, Vec3, Vec4};

use super::{Args, shared::rotation::rotate};
use crate::{
    layout::{JointPose, Vertex},
    pass::skin_dqs::Constants,
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
    let rotation = args.write::<[f32; 4]>(8);
    let stretched = palette[0].stretch1[3] != 0.0;
    for row in 0..c.rows as usize {
        let v = vertex_of[row] as usize;
        let blend = blend(v, &c, joints, weights, palette);
        let rest = Vec3::from_array(vertices[v].position);
        let (p, n) = blend.apply(rest, Vec3::from_slice(&row_normal[row]), stretched);
        position[row] = p.extend(0.0).to_array();
        normal[row] = (n / n.length().max(1e-20)).extend(0.0).to_array();
        rotation[row] = blend.real.to_array();
    }
}

/// Blended stretch and unit dual quaternion of a vertex.
struct Blend {
    stretch: Mat3,
    real: Vec4,
    dual: Vec4,
}

impl Blend {
    fn apply(&self, p: Vec3, n: Vec3, stretched: bool) -> (Vec3, Vec3) {
        let (p, n) = if stretched {
            let [c0, c1, c2] = [
                self.stretch.x_axis,
                self.stretch.y_axis,
                self.stretch.z_axis,
            ];
            let cofactor = Mat3::from_cols(c1.cross(c2), c2.cross(c0), c0.cross(c1));
            (self.stretch * p, cofactor * n)
        } else {
            (p, n)
        };
        let (r, d) = (self.real.truncate(), self.dual.truncate());
        let shift = 2.0 * (self.real.w * d - self.dual.w * r + r.cross(d));
        (rotate(self.real, p) + shift, rotate(self.real, n))
    }
}

fn blend(v: usize, c: &Constants, joints: &[u32], weights: &[f32], palette: &[JointPose]) -> Blend {
    let (mut real, mut dual, mut pivot) = (Vec4::ZERO, Vec4::ZERO, Vec4::ZERO);
    let (mut diagonal, mut off) = (Vec3::ZERO, Vec3::ZERO);
    for k in 0..c.width as usize {
        let at = v * c.width as usize + k;
        let w = weights[at];
        if w == 0.0 {
            break;
        }
        let joint = &palette[joint_at(joints, at)];
        let q = Vec4::from_array(joint.real);
        if k == 0 {
            pivot = q;
        }
        // q and −q are the same rotation: blend on the side of the heaviest joint.
        let s = if q.dot(pivot) < 0.0 { -w } else { w };
        real += s * q;
        dual += s * Vec4::from_array(joint.dual);
        let (a, b) = (joint.stretch0, joint.stretch1);
        diagonal += w * Vec3::new(a[0], b[0], b[2]);
        off += w * Vec3::new(a[1], a[2], b[1]);
    }
    let l = real.length();
    Blend {
        stretch: Mat3::from_cols(
            Vec3::new(diagonal.x, off.x, off.y),
            Vec3::new(off.x, diagonal.y, off.z),
            Vec3::new(off.y, off.z, diagonal.z),
        ),
        real: real / l,
        dual: dual / l,
    }
}

/// Joint row of influence `at`; two are packed in a word.
pub(super) fn joint_at(joints: &[u32], at: usize) -> usize {
    ((joints[at >> 1] >> ((at & 1) * 16)) & 0xffff) as usize
}
