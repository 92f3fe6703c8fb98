//! Twin of `shaders/index.comp`. The shader first culls a workgroup's 4³ cells at once; here each cell tests every field.

use glam::{UVec3, Vec3, Vec4};
use rayon::prelude::*;

use super::{Args, cast};
use crate::layout::{CELLS, FieldPose, FieldsHead};

const MARGIN: f32 = 1e-4;

/// Builds the index.
pub fn run(args: &mut Args<'_>) {
    let words = args.read::<u32>(0);
    let index = args.write::<u32>(1);
    let split = size_of::<FieldsHead>() / 4;
    let head: FieldsHead = bytemuck::pod_read_unaligned(bytemuck::cast_slice(&words[..split]));
    let fields = &cast::<FieldPose>(&words[split..])[..head.grid_inverse[3] as usize];
    let origin = Vec3::from_slice(&head.grid_origin);
    let cell = 1.0 / Vec3::from_slice(&head.grid_inverse);
    let per_cell = head.grid_origin[3] as usize;
    let cells = (CELLS * CELLS * CELLS) as usize;
    index[..cells * per_cell]
        .par_chunks_mut(per_cell)
        .enumerate()
        .for_each(|(at, mask)| {
            let at = at as u32;
            let id = UVec3::new(at % CELLS, at / CELLS % CELLS, at / (CELLS * CELLS));
            let group = origin + ((id / 4).as_vec3() * 4.0 + 2.0) * cell;
            let centre = origin + (id.as_vec3() + 0.5) * cell;
            mask.fill(0);
            for (i, field) in fields.iter().enumerate() {
                if meets(field, group, 2.0 * cell) && meets(field, centre, 0.5 * cell) {
                    mask[i >> 5] |= 1 << (i & 31);
                }
            }
        });
}

/// The axis-aligned box (centre, half) meets the field's box, tested along the field's axes.
fn meets(field: &FieldPose, centre: Vec3, half: Vec3) -> bool {
    field.rows.iter().all(|row| {
        let row = Vec4::from_array(*row);
        let at = row.truncate().dot(centre) + row.w;
        let reach = row.truncate().abs().dot(half) + MARGIN;
        at + reach >= 0.0 && at - reach <= 1.0
    })
}
