//! Twin of `shaders/measure.comp`.

use glam::Vec3;
use rayon::prelude::*;

use super::{Args, shared::field::Composite};
use crate::pass::measure::Constants;

/// Evaluates the composed field at every vertex.
pub fn run(args: &mut Args<'_>) {
    let c: Constants = args.constants();
    let position = args.read::<[f32; 4]>(0);
    let value = args.write::<f32>(1);
    let direction = args.write::<[f32; 4]>(2);
    let field = Composite::new(args, 3);
    let count = c.vertices as usize;
    value[..count]
        .par_iter_mut()
        .zip(&mut direction[..count])
        .zip(position)
        .for_each(|((value, direction), p)| {
            let x = Vec3::from_slice(p);
            let (f, g) = field.evaluate(x, &mut 0);
            *value = f;
            let around = field.around(x) as f32;
            *direction = (g / g.length().max(1e-20)).extend(around).to_array();
        });
}
