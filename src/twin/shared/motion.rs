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
    /// Number of the motion that all joints of a vertex have; [`NO_MOTION`] where they differ.
    pub fn of(&self, v: usize) -> u32 {
        let influences = v * self.width as usize..(v + 1) * self.width as usize;
        let motion = |at: usize| self.palette[joint_at(self.joints, at)].stretch0[3] as u32;
        let first = motion(influences.start);
        let same = influences
            .filter(|at| self.weights[*at] > 0.0)
            .all(|at| motion(at) == first);
        if same { first } else { NO_MOTION }
    }
}
