//! Bodies as smooth unions of round cones.

use dermis::asset::Model;
use glam::DVec3;

/// A round cone between two spheres, belonging to a joint; its cross-section may be wider along one direction.
#[derive(Clone, Debug)]
pub(crate) struct Part {
    /// Row of the joint that the part belongs to.
    pub(crate) joint: usize,
    from: DVec3,
    to: DVec3,
    radius: [f64; 2],
    wide: Option<(DVec3, f64)>,
}

impl Part {
    /// A round cone from `from` to `to` with a radius at each end.
    pub(crate) fn new(joint: usize, from: DVec3, to: DVec3, radius: [f64; 2]) -> Self {
        Self {
            joint,
            from,
            to,
            radius,
            wide: None,
        }
    }

    /// A ball.
    pub(crate) fn ball(joint: usize, center: DVec3, radius: f64) -> Self {
        Self::new(joint, center, center, [radius; 2])
    }

    /// The same, `factor` times as wide along `direction` (a unit vector).
    pub(crate) fn wide(mut self, direction: DVec3, factor: f64) -> Self {
        self.wide = Some((direction, factor));
        self
    }

    /// Distance to the surface, negative inside; exact where the part is round and both radii are alike.
    fn distance(&self, point: DVec3) -> f64 {
        let (mut q, mut bone) = (point - self.from, self.to - self.from);
        let mut least = 1.0;
        if let Some((direction, factor)) = self.wide {
            // Squeezing space along the direction makes the part round again.
            let squeeze = |v: DVec3| v + direction * (v.dot(direction) * (1.0 / factor - 1.0));
            (q, bone) = (squeeze(q), squeeze(bone));
            least = factor.min(1.0);
        }
        let squared = bone.length_squared();
        let t = if squared > 0.0 {
            (q.dot(bone) / squared).clamp(0.0, 1.0)
        } else {
            0.0
        };
        let radius = self.radius[0] + (self.radius[1] - self.radius[0]) * t;
        ((q - bone * t).length() - radius) * least
    }
}

/// Parts that melt into each other, and together into the core.
#[derive(Clone, Debug)]
pub(crate) struct Limb {
    /// The parts.
    pub(crate) parts: Vec<Part>,
    /// Width of the fillet between the parts.
    pub(crate) inner: f64,
    /// Width of the fillet to the core; no matter in the core itself.
    pub(crate) fillet: f64,
}

/// A core with limbs; limbs melt into the core and hardly into each other.
#[derive(Clone, Debug)]
pub(crate) struct Shape {
    /// Trunk or palm.
    pub(crate) core: Limb,
    /// Arms, legs, fingers.
    pub(crate) limbs: Vec<Limb>,
    /// Width of the fillet between limbs.
    pub(crate) web: f64,
}

impl Shape {
    /// Distance to the surface, roughly; negative inside.
    pub(crate) fn distance(&self, point: DVec3) -> f64 {
        let core = union(&self.core, point);
        self.limbs
            .iter()
            .map(|limb| smooth_min(core, union(limb, point), limb.fillet))
            .reduce(|a, b| smooth_min(a, b, self.web))
            .unwrap_or(core)
    }

    /// Direction in which the distance grows, times its slope.
    pub(crate) fn gradient(&self, p: DVec3) -> DVec3 {
        const STEP: f64 = 1e-5;
        let slope = |axis: DVec3| self.distance(p + axis * STEP) - self.distance(p - axis * STEP);
        DVec3::new(slope(DVec3::X), slope(DVec3::Y), slope(DVec3::Z)) / (2.0 * STEP)
    }

    /// Moves a point near the surface onto it (Newton's method along the gradient).
    pub(crate) fn project(&self, mut point: DVec3) -> DVec3 {
        for _ in 0..4 {
            let gradient = self.gradient(point);
            point -= gradient * (self.distance(point) / gradient.length_squared().max(1e-6));
        }
        point
    }

    /// The joint whose part is nearest.
    pub(crate) fn joint(&self, point: DVec3) -> usize {
        let parts = self
            .limbs
            .iter()
            .flat_map(|limb| &limb.parts)
            .chain(&self.core.parts);
        parts
            .map(|part| (part.distance(point), part.joint))
            .min_by(|a, b| a.0.total_cmp(&b.0))
            .map_or(0, |(_, joint)| joint)
    }
}

fn union(limb: &Limb, point: DVec3) -> f64 {
    let distances = limb.parts.iter().map(|part| part.distance(point));
    distances.fold(f64::INFINITY, |a, b| smooth_min(a, b, limb.inner))
}

/// Minimum with a fillet: polynomial where the two differ by less than `width`, exact elsewhere.
fn smooth_min(a: f64, b: f64, width: f64) -> f64 {
    let overlap = (width - (a - b).abs()).max(0.0);
    // Infinity minus a number leaves no overlap.
    a.min(b) - overlap * overlap / (4.0 * width)
}

/// Appends a one-piece skin to a model: single primitive, normals as given.
pub(crate) fn put_skin(
    model: &mut Model,
    color: [f32; 4],
    positions: &[DVec3],
    normals: &[DVec3],
    triangles: Vec<[u32; 3]>,
) {
    let name = model
        .path
        .file_stem()
        .unwrap_or_default()
        .to_string_lossy()
        .into_owned();
    model.positions = positions.iter().map(|p| p.as_vec3()).collect();
    model.normals = normals.iter().map(|n| n.as_vec3().normalize()).collect();
    model.primitives = vec![dermis::asset::Primitive {
        name: format!("{name}/0"),
        vertices: 0..positions.len(),
        triangles: 0..triangles.len(),
        base_color: color,
    }];
    model.triangles = triangles;
}
