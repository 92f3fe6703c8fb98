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
    let field = Composite::new(args, 2);
    value[..c.vertices as usize]
        .par_iter_mut()
        .zip(position)
        .for_each(|(value, p)| *value = field.evaluate(Vec3::from_slice(p), &mut 0).0);
}
