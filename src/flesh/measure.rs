//! What a deformation does to volumes: of a whole mesh, of small cells along its surface, of a cloud of cubes (Figs. 9 and 10).

use glam::DVec3;

use super::{
    bend::Bent,
    register::{INVALID, Registration},
};
use crate::Result;

/// Edges whose ends are this many times their length apart along the spine are torn.
const TORN: f64 = 10.0;
/// Cubes of a cloud may differ this many times their size along the spine, and are so many sizes from a limit.
const CUBE_SPREAD: f64 = 6.0;

/// Relative errors of the volumes of small pieces.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LocalError {
    /// Number of pieces.
    pub cells: usize,
    /// Mean of the absolute errors.
    pub mean: f64,
    /// Greatest absolute error.
    pub worst: f64,
}

impl LocalError {
    fn of(errors: impl IntoIterator<Item = f64>) -> Self {
        let mut out = Self::default();
        let mut sum = 0.0;
        for error in errors {
            out.cells += 1;
            sum += error.abs();
            out.worst = out.worst.max(error.abs());
        }
        out.mean = sum / out.cells.max(1) as f64;
        out
    }
}

/// Volume within a closed mesh, positive where triangles are counter-clockwise from outside.
pub fn volume(positions: &[DVec3], triangles: &[[u32; 3]]) -> f64 {
    // About a point of the mesh, where cancellation is least.
    let origin = positions.first().copied().unwrap_or_default();
    let six = |t: &[u32; 3]| {
        let [a, b, c] = t.map(|row| positions[row as usize] - origin);
        a.dot(b.cross(c))
    };
    triangles.iter().map(six).sum::<f64>() / 6.0
}

/// Tetrahedra along the surface of a mesh, one a triangle, as deep as it is wide, and what becomes of their volume.
///
/// `map` deforms any points. Triangles without area, and those around which the map is not valid, are left out.
///
/// # Errors
/// Those of `map`.
pub fn surface_error(
    positions: &[DVec3],
    triangles: &[[u32; 3]],
    map: impl Fn(&[DVec3]) -> Result<Bent>,
) -> Result<LocalError> {
    let corners = |t: &[u32; 3]| t.map(|row| positions[row as usize]);
    let apex = |t: &[u32; 3]| {
        let [a, b, c] = corners(t);
        let normal = (b - a).cross(c - a);
        // The side of a square as large as the triangle.
        (a + b + c) / 3.0 - (0.5 * normal.length()).sqrt() * normal.normalize_or_zero()
    };
    let all: Vec<DVec3> = positions
        .iter()
        .copied()
        .chain(triangles.iter().map(apex))
        .collect();
    let bent = map(&all)?;
    let error = |(row, t): (usize, &[u32; 3])| {
        let [a, b, c] = t.map(|r| r as usize);
        let rows = [a, b, c, positions.len() + row];
        let before = tetrahedron(rows.map(|r| all[r]));
        let valid = rows.iter().all(|&r| bent.flags[r] & INVALID == 0);
        (before != 0.0 && valid)
            .then(|| tetrahedron(rows.map(|r| bent.positions[r])) / before - 1.0)
    };
    Ok(LocalError::of(
        triangles.iter().enumerate().filter_map(error),
    ))
}

fn tetrahedron([a, b, c, d]: [DVec3; 4]) -> f64 {
    (b - a).dot((c - a).cross(d - a)) / 6.0
}

/// A grid of cubes, `across` of them along the longest side of the box from `low` to `high`, and what becomes of their volume.
///
/// `map` deforms any points and tells their arc lengths at rest. Cubes that are near a limit or torn are left out.
///
/// # Errors
/// Those of `map`.
pub fn cube_error(
    [low, high]: [DVec3; 2],
    across: u32,
    map: impl Fn(&[DVec3]) -> Result<(Bent, Vec<f64>)>,
) -> Result<LocalError> {
    let size = (high - low).max_element() / f64::from(across.max(1));
    let counts = ((high - low) / size).round().max(DVec3::ONE);
    let counts = counts.to_array().map(|c| c as usize);
    let corner = |row: usize| {
        let [x, y, z] = unfold(row, counts.map(|c| c + 1));
        low + size * DVec3::new(x as f64, y as f64, z as f64)
    };
    let points: Vec<DVec3> = (0..counts.iter().map(|c| c + 1).product())
        .map(corner)
        .collect();
    let (bent, arcs) = map(&points)?;
    let error = |cube: usize| {
        let [x, y, z] = unfold(cube, counts);
        let row = |i: usize| {
            let (x, y, z) = (x + (i & 1), y + (i >> 1 & 1), z + (i >> 2));
            x + (counts[0] + 1) * (y + (counts[1] + 1) * z)
        };
        let rows: [usize; 8] = std::array::from_fn(row);
        let fine = |r: &usize| bent.flags[*r] & INVALID == 0 && bent.distances[*r] > size;
        let arcs = rows.map(|r| arcs[r]);
        let spread = arcs.iter().copied().fold(f64::NEG_INFINITY, f64::max)
            - arcs.iter().copied().fold(f64::INFINITY, f64::min);
        let fine = rows.iter().all(fine) && spread < CUBE_SPREAD * size;
        fine.then(|| hexahedron(rows.map(|r| bent.positions[r])) / size.powi(3) - 1.0)
    };
    Ok(LocalError::of(
        (0..counts.iter().product()).filter_map(error),
    ))
}

fn unfold(row: usize, [x, y, _]: [usize; 3]) -> [usize; 3] {
    [row % x, row / x % y, row / (x * y)]
}

/// Volume of a cube with bent faces, each the mean of the two ways to cut it in two. Corner i is at the bits of i.
fn hexahedron(corners: [DVec3; 8]) -> f64 {
    // Counter-clockwise from outside.
    const FACES: [[usize; 4]; 6] = [
        [0, 4, 6, 2],
        [1, 3, 7, 5],
        [0, 1, 5, 4],
        [2, 6, 7, 3],
        [0, 2, 3, 1],
        [4, 5, 7, 6],
    ];
    let six = |a: usize, b: usize, c: usize| {
        let [a, b, c] = [a, b, c].map(|i| corners[i] - corners[0]);
        a.dot(b.cross(c))
    };
    let face = |[a, b, c, d]: [usize; 4]| six(a, b, c) + six(a, c, d) + six(a, b, d) + six(b, c, d);
    FACES.into_iter().map(face).sum::<f64>() / 12.0
}

/// Triangles whose corners lie on parts of the spine far from each other: the mesh is torn there, whatever its flags.
pub fn torn(registered: &Registration, positions: &[DVec3], triangles: &[[u32; 3]]) -> usize {
    let apart = |a: u32, b: u32| {
        let [a, b] = [a as usize, b as usize];
        let mut gap = (registered.anchors[a].arc - registered.anchors[b].arc).abs();
        if registered.closed {
            gap = gap.min(registered.length - gap);
        }
        gap > TORN * positions[a].distance(positions[b])
    };
    let torn = |t: &&[u32; 3]| apart(t[0], t[1]) || apart(t[1], t[2]) || apart(t[2], t[0]);
    triangles.iter().filter(torn).count()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::flesh::{BendOptions, Curve, Map, Round, Spine, SpineDesc, bend, register};

    fn spines() -> (Spine, Spine) {
        let line = Curve::BSpline(vec![DVec3::ZERO, 4.0 * DVec3::X]);
        let rest = Spine::new(&SpineDesc::new(line)).unwrap();
        let round = Round {
            start: DVec3::ZERO,
            tangent: DVec3::X,
            normal: DVec3::Y,
            radius: 2.5,
            length: 4.0,
        };
        let helix = Curve::Helix { round, pitch: 2.0 };
        let bent = Spine::like(&SpineDesc::new(helix), &rest).unwrap();
        (rest, bent)
    }

    /// Fig. 10: the error of the cubes comes from their straight edges alone.
    #[test]
    fn the_error_of_cubes_falls_with_the_square_of_their_size() {
        let (rest, bent) = spines();
        let bounds = [DVec3::new(0.0, -0.6, -0.6), DVec3::new(4.0, 0.6, 0.6)];
        for map in [Map::Radial, Map::Normal, Map::Binormal] {
            let error = |across: u32, strength: f64| {
                let way = |points: &[DVec3]| {
                    let registered = register(&rest, map, points, &[])?;
                    let options = BendOptions {
                        strength,
                        ..BendOptions::default()
                    };
                    let arcs = registered.anchors.iter().map(|a| a.arc).collect();
                    Ok((bend(&registered, &bent, &options)?, arcs))
                };
                cube_error(bounds, across, way).unwrap()
            };
            let [coarse, middle, fine] = [20, 40, 80].map(|n| error(n, 1.0));
            assert_eq!(coarse.cells, 20 * 6 * 6);
            for (a, b) in [(coarse, middle), (middle, fine)] {
                let ratio = a.mean / b.mean;
                assert!((3.8..4.2).contains(&ratio), "{map:?} {a:?} {b:?}");
            }
            assert!(fine.mean < 1e-3, "{map:?} {fine:?}");
            let plain = error(80, 0.0);
            assert!(plain.mean > 0.05, "{plain:?}");
        }
    }

    #[test]
    fn a_cube_and_its_cells_have_their_volume() {
        let corner =
            |i: u32| DVec3::new(f64::from(i & 1), f64::from(i >> 1 & 1), f64::from(i >> 2));
        let corners: Vec<DVec3> = (0..8).map(|i| corner(i) + 5.0).collect();
        let faces = [
            [0, 4, 6, 2],
            [1, 3, 7, 5],
            [0, 1, 5, 4],
            [2, 6, 7, 3],
            [0, 2, 3, 1],
            [4, 5, 7, 6],
        ];
        let triangles: Vec<[u32; 3]> = faces
            .iter()
            .flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]])
            .collect();
        assert!((volume(&corners, &triangles) - 1.0).abs() < 1e-12);
        assert!((hexahedron(std::array::from_fn(|i| corners[i])) - 1.0).abs() < 1e-12);
        let stretched = |points: &[DVec3]| {
            let twice = |p: &DVec3| DVec3::new(2.0 * p.x, p.y, p.z);
            Ok(Bent {
                positions: points.iter().map(twice).collect(),
                flags: vec![0; points.len()],
                ..Bent::default()
            })
        };
        let found = surface_error(&corners, &triangles, stretched).unwrap();
        assert_eq!(found.cells, 12);
        assert!((found.mean - 1.0).abs() < 1e-12 && (found.worst - 1.0).abs() < 1e-12);
    }
}
