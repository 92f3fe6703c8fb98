//! Twin of `shaders/output.comp`.

use super::Args;
use crate::pass::output::{BYTE_NORMALS, Constants, FLOAT_NORMALS};

/// Writes positions and normals into the host's vertices.
pub fn run(args: &mut Args<'_>) {
    let c: Constants = args.constants();
    let positions = args.read::<[f32; 4]>(0);
    let normals = args.read::<[f32; 4]>(1);
    let vertices = args.write::<u32>(2);
    let mut store = |at: usize, x: [f32; 4]| {
        for (to, x) in vertices[at..at + 3].iter_mut().zip(x) {
            *to = x.to_bits();
        }
    };
    let at = |row: usize| c.offset as usize + row * c.stride as usize;
    let normal_at = |row: usize| at(row) + c.normal_offset as usize;
    let rows = positions.iter().zip(normals).take(c.rows as usize);
    for (row, (position, normal)) in rows.enumerate() {
        store(at(row), *position);
        if c.normals == FLOAT_NORMALS {
            store(normal_at(row), *normal);
        }
    }
    if c.normals == BYTE_NORMALS {
        for (row, normal) in normals.iter().enumerate().take(c.rows as usize) {
            let [x, y, z, _] = normal.map(byte);
            vertices[normal_at(row)] = u32::from_le_bytes([x, y, z, 0]);
        }
    }
}

/// A signed normalised byte.
fn byte(x: f32) -> u8 {
    (x.clamp(-1.0, 1.0) * 127.0).round_ties_even() as i8 as u8
}
