//! Twin of `shaders/shared/motion.glsl`.

use crate::{
    layout::{JointPose, NO_MOTION},
    twin::skin_dqs::joint_at,
};

/// The influences of all vertices and the posed joints.
#[derive(Clone, Copy, Debug)]
pub struct Motions<'a> {
    /// Joint rows, two a word.
    pub joints: &'a [u32],
    /// Weights.
    pub weights: &'a [f32],
    /// Posed joints.
    pub palette: &'a [JointPose],
    /// Influences a vertex.
    pub width: u32,
}

impl Motions<'_> {
    /// Numbers of the motions that all joints of a vertex have, since the pose before and since rest; [`NO_MOTION`] where
    /// they differ.
    pub fn of(&self, v: usize) -> [u32; 2] {
        let influences = v * self.width as usize..(v + 1) * self.width as usize;
        let both = |at: usize| self.palette[joint_at(self.joints, at)].motions();
        let first = both(influences.start);
        let counted = influences.filter(|at| self.weights[*at] != 0.0);
        let mut motions = first;
        for other in counted.map(both) {
            for k in 0..2 {
                if other[k] != first[k] {
                    motions[k] = NO_MOTION;
                }
            }
        }
        motions
    }
}
