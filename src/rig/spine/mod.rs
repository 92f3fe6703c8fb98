//! Chains of joints as spines: which vertices bend by fleshing (2013), and all that follows from the rest pose.
//!
//! The spine is a smooth curve through the chain's joints and the end of its last bone, in the rest pose and in any other; a
//! vertex keeps its place along it and across it, where it would be were the spine straight. As the length between two joints
//! may change along the curve, the cross-section gives way to that, too.

mod chain;
mod curve;
mod place;

use glam::{DVec3, Vec3};
use rayon::prelude::*;

use super::{Skeleton, Weights};
use crate::{Result, flesh::Map, mesh::Mesh};

use chain::Chain;
use place::Foot;

/// A chain of joints that bends by fleshing.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct SpineChain {
    /// Its first joint.
    pub root: String,
    /// Its last joint, the root's descendant.
    pub tip: String,
    /// In which direction flesh gives way.
    pub map: Map,
}

/// A point that a spine goes through.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpinePoint {
    /// Joint that carries it.
    pub joint: u16,
    /// Where it is at rest.
    pub position: Vec3,
}

/// A welded vertex that follows a spine.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FleshPlace {
    /// Its row.
    pub vertex: u32,
    /// Row of its spine.
    pub spine: u32,
    /// How much it follows the spine, in (0, 1]; the rest of it follows the method.
    pub weight: f32,
    /// Unit tangent of the rest spine at the closest point.
    pub tangent: Vec3,
    /// First vector of the frame there, across the tangent; the second is tangent × side.
    pub side: Vec3,
    /// Where it would be across the spine, were that straight, in this frame.
    pub straight: [f32; 2],
    /// How far it is past an end of the spine, along the tangent there; 0 between the ends.
    pub past: f32,
    /// Length of the rest spine a unit of its parameter, and the derivative of its logarithm by the parameter.
    pub speed: [f32; 2],
    /// Derivative of the tangent by the parameter, in this frame.
    pub turning: [f32; 2],
    /// Joints whose rotations blend to the frame's.
    pub joints: [u16; 2],
    /// Share of the second of these, and its derivative by the parameter.
    pub share: [f32; 2],
    /// Derivatives of the rest position by arc length and by both coordinates of `straight`: what a normal needs.
    pub basis: [Vec3; 3],
    /// Room to the limit of the map at rest, as a share of the radius of curvature: 1 on the spine, 0 at the limit.
    pub room: f32,
}

/// All spines of a character.
#[derive(Clone, Debug, Default)]
pub struct Fleshing {
    /// The chains, as the user named them.
    pub chains: Vec<SpineChain>,
    /// Points of all spines, those of a spine together.
    pub points: Vec<SpinePoint>,
    /// Vertices of the chains that are past the limit of their spine's map at rest: they follow the method.
    pub past_limit: usize,
    /// Where the points of each spine begin, and the end of the last.
    pub offsets: Vec<u32>,
    /// Vertices that follow a spine, ascending.
    pub places: Vec<FleshPlace>,
    /// Of each place, weights of the spine's points in the curve and its first three derivatives by its parameter; those of
    /// a place together.
    pub weights: Vec<[f32; 4]>,
}

impl Fleshing {
    /// Vertices of a character with the parts `part` on the spines of these chains. A vertex follows a spine by the sum of its
    /// weights for the chain's joints; of several spines, the one of which it has most.
    ///
    /// # Errors
    /// [`Error::Joint`](crate::Error::Joint) for a joint that does not exist, a tip that does not descend from its root, a chain
    /// without length, a joint that is in two chains.
    pub(crate) fn new(
        chains: &[SpineChain],
        skeleton: &Skeleton,
        mesh: &Mesh,
        weights: &Weights,
        part: &[u16],
    ) -> Result<Self> {
        let mut fleshing = Self {
            chains: chains.to_vec(),
            offsets: vec![0],
            ..Self::default()
        };
        let mut spines = Vec::new();
        for chain in chains {
            let spine = Chain::new(chain, skeleton, mesh, part)?;
            chain::check_free(&spines, &spine, skeleton)?;
            fleshing.points.extend(&spine.points);
            fleshing.offsets.push(fleshing.points.len() as u32);
            spines.push(spine);
        }
        let rows = (0..mesh.positions.len()).into_par_iter();
        let placed = rows.filter_map(|vertex| fleshing.place(vertex, &spines, mesh, weights));
        for (place, weights) in placed.collect::<Vec<_>>() {
            if place.weight > 0.0 {
                fleshing.places.push(place);
                fleshing.weights.extend(weights);
            } else {
                fleshing.past_limit += 1;
            }
        }
        Ok(fleshing)
    }

    /// The place of a vertex if it follows a spine, and its points' weights.
    fn place(
        &self,
        vertex: usize,
        spines: &[Chain],
        mesh: &Mesh,
        weights: &Weights,
    ) -> Option<(FleshPlace, Vec<[f32; 4]>)> {
        let follows = |spine: &Chain| spine.weight(vertex, weights);
        let of = |row: usize| follows(&spines[row]);
        let most = (0..spines.len()).max_by(|a, b| of(*a).total_cmp(&of(*b)));
        let (row, weight) = most.map(|row| (row, of(row))).filter(|m| m.1 > 0.0)?;
        let position: DVec3 = mesh.positions[vertex].as_dvec3();
        let foot = Foot::new(&spines[row], position);
        let mut place = foot.place(&spines[row], position, self.chains[row].map);
        place.vertex = vertex as u32;
        place.spine = row as u32;
        place.weight = weight * place::trust(place.room);
        let single = |w: &[f64; 4]| w.map(|w| w as f32);
        let weights = foot.weights.iter().map(single).collect();
        Some((place, weights))
    }

    /// Points of a spine.
    pub fn points_of(&self, spine: usize) -> std::ops::Range<usize> {
        self.offsets[spine] as usize..self.offsets[spine + 1] as usize
    }
}
