//! A chain of joints and the curve through them at rest.

use glam::DVec3;

use super::{SpineChain, SpinePoint, curve::Spline};
use crate::{
    Error, Result,
    mesh::Mesh,
    rig::{Skeleton, Weights},
};

/// Samples a piece of the curve.
const SAMPLES: usize = 16;
/// Sum of weights from which on a vertex follows its spine wholly; rounding leaves some sums below 1.
const WHOLE: f32 = 0.999;
/// Points closer than this to the one before, as a share of the length, are left out.
const CLOSE: f64 = 1e-3;

/// A spine at rest.
pub(super) struct Chain {
    /// Its joints, from the root on.
    joints: Vec<usize>,
    /// What the curve goes through.
    pub(super) points: Vec<SpinePoint>,
    pub(super) spline: Spline,
    /// Points of the curve at rest at even steps of its parameter, for a coarse search.
    pub(super) samples: Vec<DVec3>,
    /// Middles of the bones, by the curve's parameter: where a joint's rotation holds alone.
    pub(super) middles: Vec<(f64, u16)>,
}

impl Chain {
    pub(super) fn new(
        names: &SpineChain,
        skeleton: &Skeleton,
        mesh: &Mesh,
        part: &[u16],
    ) -> Result<Self> {
        let joints = joints(names, skeleton)?;
        let origin = |j: usize| skeleton.joints[j].bind.w_axis.truncate();
        let mut points: Vec<SpinePoint> = joints
            .iter()
            .map(|j| SpinePoint {
                joint: *j as u16,
                position: origin(*j),
            })
            .collect();
        keep_apart(&mut points);
        points.extend(end_of_bone(&points, mesh, part));
        keep_apart(&mut points);
        let refused = |reason: &str| Error::Joint {
            joint: names.root.clone(),
            reason: format!("the spine from it to {:?} {reason}", names.tip),
        };
        let knots = knots(&points);
        if points.len() < 2 {
            return Err(refused("has no length"));
        }
        let middles = knots.windows(2).zip(&points);
        let middles = middles.map(|(k, from)| (0.5 * (k[0] + k[1]), from.joint));
        let middles = middles.collect();
        let spline =
            Spline::new(knots).ok_or_else(|| refused("has joints too close to tell apart"))?;
        let mut chain = Self {
            joints,
            points,
            spline,
            samples: Vec::new(),
            middles,
        };
        let pieces = SAMPLES * (chain.points.len() - 1);
        let at = |k: usize| chain.end() * k as f64 / pieces as f64;
        let sample = |k: usize| chain.jet(&chain.spline.weights(at(k)))[0];
        chain.samples = (0..=pieces).map(sample).collect();
        Ok(chain)
    }

    /// How much a vertex follows the chain's joints: their weights' sum, with no kink where it begins and where it ends.
    pub(super) fn weight(&self, vertex: usize, weights: &Weights) -> f32 {
        let row = vertex * weights.width..(vertex + 1) * weights.width;
        let influences = weights.joints[row.clone()]
            .iter()
            .zip(&weights.weights[row]);
        let own = influences.filter(|(j, _)| self.joints.contains(&usize::from(**j)));
        let sum: f32 = own.map(|(_, w)| w).sum();
        super::place::smooth(sum / WHOLE)
    }

    /// Derivatives of the curve at rest.
    pub(super) fn jet(&self, weights: &[[f64; 4]]) -> [DVec3; 4] {
        let mut sum = [DVec3::ZERO; 4];
        for (weights, point) in weights.iter().zip(&self.points) {
            for (slot, weight) in sum.iter_mut().zip(weights) {
                *slot += *weight * point.position.as_dvec3();
            }
        }
        sum
    }
}

/// No joint has two spines.
pub(super) fn check_free(others: &[Chain], chain: &Chain, skeleton: &Skeleton) -> Result<()> {
    let taken = |joint: &&usize| others.iter().any(|other| other.joints.contains(joint));
    match chain.joints.iter().find(taken) {
        Some(joint) => Err(Error::Joint {
            joint: skeleton.joints[*joint].name.clone(),
            reason: "it is in two spines".into(),
        }),
        None => Ok(()),
    }
}

/// From the tip up to the root, then turned around.
fn joints(names: &SpineChain, skeleton: &Skeleton) -> Result<Vec<usize>> {
    let (root, tip) = (skeleton.find(&names.root)?, skeleton.find(&names.tip)?);
    let parents = |joint: &usize| skeleton.joints[*joint].parent;
    let mut joints: Vec<usize> = std::iter::successors(Some(tip), parents).collect();
    let Some(row) = joints.iter().position(|joint| *joint == root) else {
        return Err(Error::Joint {
            joint: names.tip.clone(),
            reason: format!(
                "a spine from {:?} cannot end at it: it is no descendant",
                names.root
            ),
        });
    };
    joints.truncate(row + 1);
    joints.reverse();
    Ok(joints)
}

/// The end of the last bone: as far as its part goes, straight on from the bone before; of a single bone, towards its part's
/// middle.
fn end_of_bone(points: &[SpinePoint], mesh: &Mesh, part: &[u16]) -> Option<SpinePoint> {
    let tip = points.last()?;
    let origin = tip.position.as_dvec3();
    let own = mesh.positions.iter().zip(part);
    let own: Vec<DVec3> = own
        .filter(|(_, p)| **p == tip.joint)
        .map(|(x, _)| x.as_dvec3() - origin)
        .collect();
    let direction = match points {
        [.., before, _] => origin - before.position.as_dvec3(),
        _ => own.iter().sum(),
    };
    let direction = direction.try_normalize()?;
    let reach = own.iter().map(|x| x.dot(direction)).fold(0.0, f64::max);
    (reach > 0.0).then(|| SpinePoint {
        joint: tip.joint,
        position: (origin + reach * direction).as_vec3(),
    })
}

/// Leaves out points that are where the one before is.
fn keep_apart(points: &mut Vec<SpinePoint>) {
    let length = knots(points).last().copied().unwrap_or(0.0);
    points.dedup_by(|later, earlier| {
        let gap = later
            .position
            .as_dvec3()
            .distance(earlier.position.as_dvec3());
        gap <= CLOSE * length
    });
}

/// Chords added up.
fn knots(points: &[SpinePoint]) -> Vec<f64> {
    let mut at = 0.0;
    let mut knots = vec![0.0];
    for pair in points.windows(2) {
        at += pair[0]
            .position
            .as_dvec3()
            .distance(pair[1].position.as_dvec3());
        knots.push(at);
    }
    knots
}
