//! Twin of `shaders/field_grid.comp`.

use glam::Vec3;
use half::f16;
use rayon::prelude::*;

use crate::{
    field::{AtlasLayout, GRID, GridInput},
    layout::field_grid::{GridCenter, GridField, GridSegment},
    pass::field_grid::Constants,
};

/// Texels of every field's grid, x fastest: f and ∂f/∂(box coordinates); texel i lies at box coordinate i / 31.
pub fn run(input: &GridInput, constants: &Constants) -> Vec<Vec<[f16; 4]>> {
    let edge = GRID as usize;
    input
        .fields
        .par_iter()
        .map(|field| {
            (0..edge * edge * edge)
                .into_par_iter()
                .map(|i| {
                    let texel = [i % edge, i / edge % edge, i / edge / edge];
                    sample(input, field, texel, constants)
                })
                .collect()
        })
        .collect()
}

/// The atlas image, x fastest, from every field's grid; tiles without a field are 0.
pub fn atlas(grids: &[Vec<[f16; 4]>], layout: AtlasLayout) -> Vec<[f16; 4]> {
    let [width, height, depth] = layout.extent().map(|n| n as usize);
    let mut image = vec![[f16::ZERO; 4]; width * height * depth];
    let edge = GRID as usize;
    for (field, grid) in grids.iter().enumerate() {
        let [x, y, z] = layout.tile(field as u32).map(|t| t as usize * edge);
        for (row, texels) in grid.chunks_exact(edge).enumerate() {
            let at = ((z + row / edge) * height + y + row % edge) * width + x;
            image[at..at + edge].copy_from_slice(texels);
        }
    }
    image
}

fn sample(input: &GridInput, field: &GridField, texel: [usize; 3], c: &Constants) -> [f16; 4] {
    let coordinate = Vec3::from(texel.map(|i| i as f32)) / (GRID - 1) as f32;
    let [edge_x, edge_y, edge_z] = [field.edge_x, field.edge_y, field.edge_z].map(Vec3::from);
    let x = Vec3::from(field.origin)
        + coordinate.x * edge_x
        + coordinate.y * edge_y
        + coordinate.z * edge_z;
    let first = field.first_segment as usize;
    let bone = from_bone(&input.segments[first..first + field.segments as usize], x);
    let first = field.first_center as usize;
    let (d, slope) = hrbf(&input.centers[first..first + field.centers as usize], x);
    let (remapped, remap_slope) = remap(d / field.radius, field.radius);
    let (weight, weight_slope) = fade(bone.0, field.radius, c.fade);
    let f = weight * remapped;
    if f < c.snap {
        return [f16::ZERO; 4];
    }
    let gradient = weight * remap_slope * slope + weight_slope * remapped * bone.1;
    [
        f,
        gradient.dot(edge_x),
        gradient.dot(edge_y),
        gradient.dot(edge_z),
    ]
    .map(f16::from_f32)
}

/// Distance to the nearest segment and the direction away from it.
fn from_bone(segments: &[GridSegment], x: Vec3) -> (f32, Vec3) {
    let (mut least, mut away) = (f32::MAX, Vec3::ZERO);
    for segment in segments {
        let start = Vec3::from(segment.start);
        let axis = Vec3::from(segment.end) - start;
        let t = (x - start).dot(axis) / axis.dot(axis).max(1e-30);
        let from = x - start - t.clamp(0.0, 1.0) * axis;
        let distance = from.length();
        if distance < least {
            least = distance;
            away = from;
        }
    }
    (
        least,
        if least > 0.0 {
            away / least
        } else {
            Vec3::ZERO
        },
    )
}

/// d and ∇d (Eq. 1 with φ = t³).
fn hrbf(centers: &[GridCenter], x: Vec3) -> (f32, Vec3) {
    let (mut d, mut gradient) = (0.0f32, Vec3::ZERO);
    for center in centers {
        let delta = x - Vec3::from(center.position);
        let beta = Vec3::from(center.beta);
        let t = delta.length();
        let along = beta.dot(delta);
        d += t * (center.lambda * t * t + 3.0 * along);
        let radial = if t > 0.0 { along / t } else { 0.0 };
        gradient += 3.0 * ((center.lambda * t + radial) * delta + t * beta);
    }
    (d, gradient)
}

/// t_r at x = d/r, and its derivative by d.
fn remap(x: f32, radius: f32) -> (f32, f32) {
    let x = x.clamp(-1.0, 1.0);
    let q = x * x;
    let value = ((-0.1875 * q + 0.625) * q - 0.9375) * x + 0.5;
    (value, -0.9375 * (1.0 - q) * (1.0 - q) / radius)
}

/// Fade at distance s from the bone, and its derivative.
fn fade(s: f32, radius: f32, between: [f32; 2]) -> (f32, f32) {
    let width = (between[1] - between[0]) * radius;
    let x = ((between[1] * radius - s) / width).clamp(0.0, 1.0);
    (x * x * (3.0 - 2.0 * x), -6.0 * x * (1.0 - x) / width)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::{
        field::{Field, atlas_layout, tests::arm},
        pass::field_grid::CONSTANTS,
    };

    fn grids(fields: &[Field]) -> (AtlasLayout, Vec<Vec<[f16; 4]>>) {
        let layout = atlas_layout(fields.len(), 2048).unwrap();
        (layout, run(&GridInput::new(fields, layout), &CONSTANTS))
    }

    /// Greatest difference between a grid and its field in double precision: of f, and of the gradient over the greatest gradient.
    fn errors(field: &Field, grid: &[[f16; 4]]) -> [f64; 2] {
        let to_rest = field.bounds.to_rest();
        let (mut value, mut slope, mut steepest) = (0.0f64, 0.0f64, 0.0f64);
        for (i, texel) in grid.iter().enumerate() {
            let at = [i % 32, i / 32 % 32, i / 1024].map(|i| i as f32 / 31.0);
            let (f, gradient) = field.evaluate(to_rest.transform_point3(Vec3::from(at)));
            value = value.max((f - texel[0].to_f64()).abs());
            for axis in 0..3 {
                let edge = field.bounds.axes.col(axis) * field.bounds.size[axis];
                let exact = gradient.dot(edge.as_dvec3());
                steepest = steepest.max(exact.abs());
                if f > 1e-4 {
                    slope = slope.max((exact - texel[axis + 1].to_f64()).abs());
                }
            }
        }
        [value, slope / steepest]
    }

    #[test]
    fn grids_are_their_fields_to_half_precision_in_any_unit() {
        for (scale, origin) in [(1.0, Vec3::ZERO), (100.0, Vec3::new(900.0, 30.0, 0.0))] {
            let (_, fitted) = arm(scale, origin);
            let (_, grids) = grids(&fitted.fields);
            for (field, grid) in fitted.fields.iter().zip(&grids) {
                // 2.5e-4 is half a unit in the last place of a half float below 1; the sum in single precision adds a tenth.
                let [value, slope] = errors(field, grid);
                assert!(value < 3e-4, "{value:e}");
                assert!(slope < 1e-3, "{slope:e}");
            }
            let mut moved = fitted.fields[0].clone();
            moved.bounds.origin.x += 0.1 * scale;
            assert!(
                errors(&moved, &grids[0])[0] > 0.05,
                "a wrong grid must be noticed"
            );
        }
    }

    #[test]
    fn an_atlas_holds_every_grid_in_its_tile() {
        let (_, fitted) = arm(1.0, Vec3::ZERO);
        let (layout, grids) = grids(&fitted.fields);
        let image = atlas(&grids, layout);
        let [width, height, depth] = layout.extent().map(|n| n as usize);
        assert_eq!(image.len(), width * height * depth);
        for (row, grid) in grids.iter().enumerate() {
            let [x, y, z] = layout.tile(row as u32).map(|t| t as usize * 32);
            for i in [0, 5, 33, 17_000, 32_767] {
                let at = ((z + i / 1024) * height + y + i / 32 % 32) * width + x + i % 32;
                assert_eq!(image[at], grid[i]);
            }
        }
    }
}
