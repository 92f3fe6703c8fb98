//! Twin of `shaders/touch.comp`.

use glam::{Vec3, Vec4};

use super::{
    Args,
    shared::{field::Composite, list},
};
use crate::pass::touch::Constants;

const HALVINGS: u32 = 4;

/// Bisects the last step of every listed vertex.
pub fn run(args: &mut Args<'_>) {
    let c: Constants = args.constants();
    let listed = list::items(args, c.dispatch);
    let anchor = args.read::<[f32; 4]>(2);
    let gradient = args.read::<[f32; 4]>(3);
    let iso = args.read::<f32>(4);
    let position = args.write::<[f32; 4]>(5);
    let field = Composite::new(args, 6);
    for &v in listed {
        let v = v as usize;
        let slope = Vec4::from_array(gradient[v]);
        let before = slope.truncate();
        let (mut near, mut far) = (Vec3::from_slice(&anchor[v]), Vec3::from_slice(&position[v]));
        let (mut off, mut value) = (anchor[v][3], slope.w);
        for _ in 0..HALVINGS {
            let middle = 0.5 * (near + far);
            let (f, g) = field.evaluate(middle, &mut 0);
            let turned = g.dot(before) < c.cos_contact * g.length() * before.length();
            let distance = (f - iso[v]).abs();
            if turned || distance > off {
                far = middle;
            } else {
                (near, off, value) = (middle, distance, f);
            }
        }
        position[v] = near.extend(value).to_array();
    }
}
