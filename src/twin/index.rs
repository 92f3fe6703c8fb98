//! Twin of `shaders/index.comp`.

use glam::{UVec3, Vec3, Vec4};

use super::{Args, cast};
use crate::layout::{CELLS, FieldPose, FieldsHead, unpack, unpack_last_cell};

const MARGIN: f32 = 1e-4;

/// Enters every field into the cells that its box meets.
pub fn run(args: &mut Args<'_>) {
    let words = args.read::<u32>(0);
    let index = args.write::<u32>(2);
    let split = size_of::<FieldsHead>() / 4;
    let head: FieldsHead = bytemuck::pod_read_unaligned(bytemuck::cast_slice(&words[..split]));
    let fields = &cast::<FieldPose>(&words[split..])[..head.grid_inverse[3] as usize];
    let origin = Vec3::from_slice(&head.grid_origin);
    let cell = 1.0 / Vec3::from_slice(&head.grid_inverse);
    let per_cell = head.grid_origin[3] as usize;
    for (i, field) in fields.iter().enumerate() {
        let (first, (last, _)) = (unpack(field.first_cell), unpack_last_cell(field.last_cell));
        for id in cells(first, last) {
            if meets(field, origin + (id.as_vec3() + 0.5) * cell, 0.5 * cell) {
                let at = ((id.z * CELLS + id.y) * CELLS + id.x) as usize;
                index[at * per_cell + (i >> 5)] |= 1 << (i & 31);
            }
        }
    }
}

/// All cells of a box of cells, both corners included.
fn cells(first: [u32; 3], last: [u32; 3]) -> impl Iterator<Item = UVec3> {
    let [x, y, z] = [0, 1, 2].map(|k| first[k]..=last[k]);
    z.flat_map(move |z| {
        let x = x.clone();
        y.clone()
            .flat_map(move |y| x.clone().map(move |x| UVec3::new(x, y, z)))
    })
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
