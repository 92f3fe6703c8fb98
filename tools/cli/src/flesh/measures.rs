//! Errors of the volumes of small pieces, by the map and by plain skinning.

use dermis::{
    Result,
    flesh::{LocalError, cube_error, surface_error},
};
use glam::DVec3;
use serde::Serialize;

use super::{
    bender::{Bender, Way},
    shape::Shape,
};

/// Cubes along the longest side of the mesh, as in Fig. 9.
const ACROSS: [u32; 3] = [15, 22, 30];

/// Small pieces of one kind.
#[derive(Clone, Copy, Debug, Serialize)]
pub(super) struct Pieces {
    /// Size of a cube; of tetrahedra none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) size: Option<f64>,
    /// How many were measured.
    pub(super) cells: usize,
    /// Mean of the absolute relative errors.
    pub(super) mean_error: f64,
    /// Greatest one.
    pub(super) worst_error: f64,
    /// Mean by plain skinning.
    pub(super) plain_mean_error: f64,
}

/// Tetrahedra along the surface, then cubes of three sizes.
#[derive(Clone, Debug, Serialize)]
pub(super) struct Local {
    pub(super) surface: Pieces,
    pub(super) cubes: Vec<Pieces>,
}

impl Local {
    pub(super) fn of(shape: &Shape, bender: &Bender, way: &Way) -> Result<Self> {
        let plain = Way {
            strength: 0.0,
            ..*way
        };
        let surface = |way: &Way| {
            surface_error(&shape.positions, shape.triangles(), |points| {
                Ok(bender.bend_points(points, way)?.bent)
            })
        };
        let low = shape.positions.iter().copied().reduce(DVec3::min);
        let high = shape.positions.iter().copied().reduce(DVec3::max);
        let bounds = [low, high].map(Option::unwrap_or_default);
        let cubes = |across: u32, way: &Way| {
            cube_error(bounds, across, |points| {
                let outcome = bender.bend_points(points, way)?;
                Ok((outcome.bent, outcome.arcs))
            })
        };
        let longest = (bounds[1] - bounds[0]).max_element();
        let cube = |across: u32| {
            let size = Some(longest / f64::from(across));
            Ok(pieces(size, cubes(across, way)?, cubes(across, &plain)?))
        };
        Ok(Self {
            surface: pieces(None, surface(way)?, surface(&plain)?),
            cubes: ACROSS.into_iter().map(cube).collect::<Result<_>>()?,
        })
    }
}

fn pieces(size: Option<f64>, map: LocalError, plain: LocalError) -> Pieces {
    Pieces {
        size,
        cells: map.cells,
        mean_error: map.mean,
        worst_error: map.worst,
        plain_mean_error: plain.mean,
    }
}
