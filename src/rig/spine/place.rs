//! The place of a vertex along and across a spine at rest.

use glam::{DMat2, DVec2, DVec3};

use super::{FleshPlace, chain::Chain};
use crate::flesh::Map;

/// Newton steps after the coarse search.
const STEPS: usize = 30;
/// Room to the limit at rest from which on a vertex follows its spine wholly.
const ROOM: f32 = 0.25;

/// The closest point of a spine.
pub(super) struct Foot {
    /// The curve's parameter.
    t: f64,
    /// How far past an end.
    past: f64,
    /// Weights of the points.
    pub(super) weights: Vec<[f64; 4]>,
}

/// From 0 to 1 without a kink at either end.
pub(super) fn smooth(x: f32) -> f32 {
    let x = x.clamp(0.0, 1.0);
    x * x * (3.0 - 2.0 * x)
}

/// How much a vertex may follow a spine from whose limit it is so far at rest.
pub(super) fn trust(room: f32) -> f32 {
    smooth(room / ROOM)
}

impl Foot {
    pub(super) fn new(chain: &Chain, position: DVec3) -> Self {
        let t = closest(chain, position);
        let weights = chain.spline.weights(t);
        let [point, first, ..] = chain.jet(&weights);
        let ends = [chain.spline.knots()[0], chain.end()];
        let ahead = (position - point).dot(first.normalize());
        let past = match t {
            t if t <= ends[0] => ahead.min(0.0),
            t if t >= ends[1] => ahead.max(0.0),
            _ => 0.0,
        };
        Self { t, past, weights }
    }

    pub(super) fn place(&self, chain: &Chain, position: DVec3, map: Map) -> FleshPlace {
        let [point, first, second, third] = chain.jet(&self.weights);
        let bend = Bend::new([first, second, third]);
        let side = bend.tangent.any_orthonormal_vector();
        let lift = bend.tangent.cross(side);
        let plane = |v: DVec3| DVec2::new(v.dot(side), v.dot(lift));
        let space = |v: DVec2| v.x * side + v.y * lift;
        let (curvature, rate) = (plane(bend.curvature), plane(bend.curvature_rate));
        let offset = plane(position - point);
        let shift = map.unbend(offset, curvature, rate);
        // With the straight place kept, the offset changes along the spine.
        let inverse = invert(shift.by_offset);
        let forward = 1.0 - curvature.dot(offset);
        let basis = [
            forward * bend.tangent - space(inverse * shift.along),
            space(inverse.x_axis),
            space(inverse.y_axis),
        ];
        let (joints, share) = chain.blend(self.t);
        FleshPlace {
            vertex: 0,
            spine: 0,
            weight: 0.0,
            tangent: bend.tangent.as_vec3(),
            side: side.as_vec3(),
            straight: shift.offset.as_vec2().to_array(),
            past: self.past as f32,
            speed: [bend.speed, bend.quicken].map(|x| x as f32),
            turning: (bend.speed * curvature).as_vec2().to_array(),
            joints,
            share: share.map(|x| x as f32),
            basis: basis.map(|v| v.as_vec3()),
            room: map.room(offset, curvature) as f32,
        }
    }
}

/// A map's derivative past its limit may have none.
fn invert(matrix: DMat2) -> DMat2 {
    match matrix.determinant() {
        d if d.abs() > 1e-9 => matrix.inverse(),
        _ => DMat2::IDENTITY,
    }
}

/// A curve's tangent and curvature from its derivatives by any parameter.
pub(super) struct Bend {
    pub(super) tangent: DVec3,
    /// Towards the centre of curvature.
    pub(super) curvature: DVec3,
    /// Its derivative by arc length, less what lies along the tangent.
    pub(super) curvature_rate: DVec3,
    /// Length a unit of the parameter.
    pub(super) speed: f64,
    /// Derivative of its logarithm by the parameter.
    pub(super) quicken: f64,
}

impl Bend {
    pub(super) fn new([first, second, third]: [DVec3; 3]) -> Self {
        let speed = first.length();
        let tangent = first / speed;
        let along = second.dot(tangent);
        let across = second - along * tangent;
        // d(across)/dt, as far as it is across itself: third less what turns with the tangent.
        let rate = third - along / speed * across;
        let square = speed * speed;
        let rate = rate / square - 2.0 * along / (square * speed) * across;
        Self {
            tangent,
            curvature: across / square,
            curvature_rate: (rate - rate.dot(tangent) * tangent) / speed,
            speed,
            quicken: along / speed,
        }
    }
}

impl Chain {
    /// The curve's last parameter.
    pub(super) fn end(&self) -> f64 {
        let knots = self.spline.knots();
        knots[knots.len() - 1]
    }

    /// The two joints that hold around a parameter, the share of the second and its derivative.
    fn blend(&self, t: f64) -> ([u16; 2], [f64; 2]) {
        let after = self.middles.partition_point(|m| m.0 <= t);
        let (Some(before), Some(next)) = (after.checked_sub(1), self.middles.get(after)) else {
            let only = self.middles[after.saturating_sub(1)].1;
            return ([only; 2], [0.0; 2]);
        };
        let from = self.middles[before];
        let gap = next.0 - from.0;
        let x = (t - from.0) / gap;
        let share = x * x * x * (10.0 + x * (6.0 * x - 15.0));
        let rate = 30.0 * x * x * (1.0 - x) * (1.0 - x) / gap;
        ([from.1, next.1], [share, rate])
    }
}

/// Parameter of the closest point between the ends: the best of some, then Newton in its bracket.
fn closest(chain: &Chain, position: DVec3) -> f64 {
    let step = chain.end() / (chain.samples.len() - 1) as f64;
    let squares = chain.samples.iter().map(|p| p.distance_squared(position));
    let nearest = squares.enumerate().min_by(|a, b| a.1.total_cmp(&b.1));
    let mut t = nearest.map_or(0, |(row, _)| row) as f64 * step;
    let (mut low, mut high) = ((t - step).max(0.0), (t + step).min(chain.end()));
    for _ in 0..STEPS {
        let [point, first, second, _] = chain.jet(&chain.spline.weights(t));
        let way = position - point;
        let ahead = way.dot(first);
        match ahead > 0.0 {
            true => low = t,
            false => high = t,
        }
        let slope = first.length_squared() - way.dot(second);
        let mut next = t + ahead / slope;
        if !(slope > 0.0 && next >= low && next <= high) {
            next = 0.5 * (low + high);
        }
        let moved = (next - t).abs();
        t = next;
        if moved <= 1e-14 * chain.end() {
            break;
        }
    }
    t
}
