//! The experiment of Table 1: a solid swept by a cross-section along an arc is straightened, then bent to an arc in another plane.

use std::f64::consts::TAU;

use dermis::flesh::{BendOptions, Curve, Map, Round, Spine, SpineDesc, bend, register, volume};
use glam::{DVec2, DVec3};

/// Length of the arcs.
const LENGTH: f64 = 5.0;
/// Curvature vectors in the frame, before and after.
const BEFORE: DVec2 = DVec2::new(0.4, 0.0);
const AFTER: DVec2 = DVec2::new(-0.1, 0.45);
/// Where the spine passes the cross-section's own middle, and how large it is.
const MIDDLE: DVec2 = DVec2::new(-0.075, 0.024);
const AREA: f64 = 0.278;
const CONTOUR: usize = 4096;

/// One line of the table.
pub(crate) struct Line {
    pub(crate) name: String,
    /// Of the cross-section.
    pub(crate) area: f64,
    /// Way of its centroid over the length of the spine.
    pub(crate) ratio: f64,
    /// Area × ratio × length (Pappus and Guldin).
    pub(crate) volume: f64,
    /// Relative error of the volume.
    pub(crate) error: f64,
    /// The same of a mesh of the solid that is mapped as any other mesh.
    pub(crate) mesh_error: f64,
}

/// All lines, in the paper's order.
pub(crate) fn lines() -> dermis::Result<Vec<Line>> {
    let contour = contour();
    let original = swept("Original", &contour, BEFORE, 0.0, 0.0);
    let whole = original.volume;
    let spines = [BEFORE, DVec2::ZERO, AFTER].map(spine);
    let [before, straight, after] = spines;
    let (before, straight, after) = (before?, straight?, after?);
    let mesh = Solid::new(&before, &contour);
    let plain = |name, curvature, bent| {
        let mesh_error = mesh.error(&before, bent, Map::Radial, 0.0)?;
        Ok::<_, dermis::Error>(swept(name, &contour, curvature, whole, mesh_error))
    };
    let mut lines = vec![
        plain("Unbend", DVec2::ZERO, &straight)?,
        plain("Bend", AFTER, &after)?,
    ];
    for map in [Map::Radial, Map::Normal, Map::Binormal] {
        let section = |bent: DVec2| -> Vec<DVec2> {
            let flat = |o: &DVec2| map.unbend(*o, BEFORE, DVec2::ZERO).offset;
            let there = |o: &DVec2| map.bend(flat(o), bent, DVec2::ZERO).offset;
            contour.iter().map(there).collect()
        };
        for (step, curvature, bent) in [("Unbend", DVec2::ZERO, &straight), ("Bend", AFTER, &after)]
        {
            let mesh_error = mesh.error(&before, bent, map, 1.0)?;
            let name = format!("{map:?} {step}");
            lines.push(swept(
                &name,
                &section(curvature),
                curvature,
                whole,
                mesh_error,
            ));
        }
    }
    lines.insert(0, original);
    Ok(lines)
}

/// The table as text.
pub(crate) fn text(lines: &[Line]) -> String {
    let mut out = format!(
        "{:16} {:>8} {:>8} {:>8} {:>10} {:>10}\n",
        "", "area(R)", "rho", "vol(S)", "error", "mesh error"
    );
    for l in lines {
        out += &format!(
            "{:16} {:8.4} {:8.4} {:8.4} {:10.2e} {:10.2e}\n",
            l.name, l.area, l.ratio, l.volume, l.error, l.mesh_error
        );
    }
    out
}

/// A kidney, so that nothing is symmetric.
fn contour() -> Vec<DVec2> {
    let at = |i: usize| {
        let a = TAU * i as f64 / CONTOUR as f64;
        (1.0 + 0.25 * a.cos() - 0.2 * (2.0 * a + 0.6).sin() + 0.1 * (3.0 * a).cos())
            * DVec2::from_angle(a)
    };
    let rough: Vec<DVec2> = (0..CONTOUR).map(at).collect();
    let (area, centroid) = moments(&rough);
    let scale = (AREA / area).sqrt();
    rough
        .iter()
        .map(|p| scale * (*p - centroid) + MIDDLE)
        .collect()
}

/// Area and centroid within a closed polygon.
fn moments(polygon: &[DVec2]) -> (f64, DVec2) {
    let (mut area, mut first) = (0.0, DVec2::ZERO);
    for (row, a) in polygon.iter().enumerate() {
        let b = polygon[(row + 1) % polygon.len()];
        let cross = a.perp_dot(b);
        area += cross / 2.0;
        first += cross / 6.0 * (*a + b);
    }
    (area, first / area)
}

fn swept(name: &str, polygon: &[DVec2], curvature: DVec2, whole: f64, mesh_error: f64) -> Line {
    let (area, centroid) = moments(polygon);
    let ratio = 1.0 - curvature.dot(centroid);
    let volume = area * ratio * LENGTH;
    let error = if whole > 0.0 {
        volume / whole - 1.0
    } else {
        0.0
    };
    Line {
        name: name.into(),
        area,
        ratio,
        volume,
        error,
        mesh_error,
    }
}

/// An arc along x at its start with a curvature vector in the frame of y and z; all start with one frame.
fn spine(curvature: DVec2) -> dermis::Result<Spine> {
    let curve = match curvature == DVec2::ZERO {
        true => Curve::Polyline(vec![DVec3::ZERO, LENGTH * DVec3::X]),
        false => Curve::Arc(Round {
            start: DVec3::ZERO,
            tangent: DVec3::X,
            normal: DVec3::new(0.0, curvature.x, curvature.y),
            radius: 1.0 / curvature.length(),
            length: LENGTH,
        }),
    };
    Spine::new(&SpineDesc {
        up: Some(DVec3::Y),
        ..SpineDesc::new(curve)
    })
}

/// A mesh of the swept solid.
struct Solid {
    positions: Vec<DVec3>,
    triangles: Vec<[u32; 3]>,
}

impl Solid {
    fn new(spine: &Spine, contour: &[DVec2]) -> Self {
        let contour: Vec<DVec2> = contour.iter().step_by(16).copied().collect();
        let (around, along) = (contour.len(), 400);
        let ring = |i: usize| {
            let section = spine.section(spine.length() * i as f64 / along as f64);
            contour
                .iter()
                .map(move |o| section.point(*o))
                .collect::<Vec<_>>()
        };
        let mut positions: Vec<DVec3> = (0..=along).flat_map(ring).collect();
        let mut triangles = Vec::new();
        for i in 0..along * around {
            let next = if i % around + 1 == around {
                i + 1 - around
            } else {
                i + 1
            };
            let [a, b, c, d] = [i, next, i + around, next + around].map(|r| r as u32);
            triangles.extend([[a, b, d], [a, d, c]]);
        }
        // The caps are fans about the middle of the contour, in a plane on every spine.
        for (end, flip) in [(0, false), (along, true)] {
            cap(&mut positions, &mut triangles, (end * around, around), flip);
        }
        Self {
            positions,
            triangles,
        }
    }

    /// Relative error of the volume on another spine.
    fn error(&self, rest: &Spine, bent: &Spine, map: Map, strength: f64) -> dermis::Result<f64> {
        let registered = register(rest, map, &self.positions, &[])?;
        let options = BendOptions {
            strength,
            ..BendOptions::default()
        };
        let there = bend(&registered, bent, &options)?;
        Ok(
            volume(&there.positions, &self.triangles) / volume(&self.positions, &self.triangles)
                - 1.0,
        )
    }
}

fn cap(
    positions: &mut Vec<DVec3>,
    triangles: &mut Vec<[u32; 3]>,
    (first, count): (usize, usize),
    flip: bool,
) {
    let ring = &positions[first..first + count];
    let middle = ring.iter().sum::<DVec3>() / count as f64;
    positions.push(middle);
    let hub = positions.len() as u32 - 1;
    for i in 0..count {
        let [a, b] = [first + i, first + (i + 1) % count].map(|r| r as u32);
        triangles.push(if flip { [hub, a, b] } else { [hub, b, a] });
    }
}
