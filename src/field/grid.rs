//! Fields packed for the pass that samples their grids.

use glam::DVec3;

use super::{AtlasLayout, Field};
use crate::layout::field_grid::{GridCenter, GridField, GridSegment};

/// Input of the `field_grid` pass: three buffers.
#[derive(Clone, Debug, Default)]
pub struct GridInput {
    /// One a field.
    pub fields: Vec<GridField>,
    /// Centres of all fields.
    pub centers: Vec<GridCenter>,
    /// Segments of all fields.
    pub segments: Vec<GridSegment>,
}

impl GridInput {
    /// Packs fields for the tiles of an atlas.
    ///
    /// Everything is carried into the HRBF's own scaled coordinates in double precision, so that single precision loses nothing
    /// to a part's distance from the origin or to the character's unit.
    pub fn new(fields: &[Field], layout: AtlasLayout) -> Self {
        let mut input = Self::default();
        for (row, field) in fields.iter().enumerate() {
            let hrbf = &field.hrbf;
            let scaled = |x: glam::Vec3| (x.as_dvec3() - hrbf.origin) / hrbf.scale;
            let single = |x: DVec3| x.as_vec3().to_array();
            let edge = |axis: usize| {
                let edge = field.bounds.axes.col(axis).as_dvec3() * field.bounds.size[axis] as f64;
                single(edge / hrbf.scale)
            };
            input.fields.push(GridField {
                origin: single(scaled(field.bounds.origin)),
                radius: (field.radius as f64 / hrbf.scale) as f32,
                edge_x: edge(0),
                first_center: input.centers.len() as u32,
                edge_y: edge(1),
                centers: hrbf.centers.len() as u32,
                edge_z: edge(2),
                first_segment: input.segments.len() as u32,
                tile: layout.tile(row as u32),
                segments: field.segments.len() as u32,
            });
            let centers = hrbf.centers.iter().zip(&hrbf.lambda).zip(&hrbf.beta);
            input
                .centers
                .extend(centers.map(|((&position, &lambda), &beta)| GridCenter {
                    position: single(position),
                    lambda: lambda as f32,
                    beta: single(beta),
                    pad: 0,
                }));
            let segments = field.segments.iter().map(|[start, end]| GridSegment {
                start: single(scaled(*start)),
                pad0: 0,
                end: single(scaled(*end)),
                pad1: 0,
            });
            input.segments.extend(segments);
        }
        input
    }
}
