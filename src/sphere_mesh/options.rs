//! How a sphere-mesh is built.

/// Settings of a build.
#[derive(Clone, Debug)]
pub struct Options {
    /// How much curved places count, 0 to 1: the power of the paper's importance 1 + BBD² (κ₁² + κ₂²) with which a vertex'
    /// area is weighted. 1 is the paper's; at 0 area alone counts. Curvature spans many orders of magnitude, and at 1 a few
    /// small places outvote the rest.
    pub curvature: f64,
    /// Weight of temporal coherence (δ of Eq. 11) against the mean weight of the planes: at 0 a sphere is wherever it fits
    /// best, from about 1 on it stays near the middle of its region.
    pub temporal: f64,
    /// Whether collapses that turn large triangles over are put off.
    pub inversion: bool,
    /// Spheres; `false` gives radius 0 throughout, the classic quadric error metric summed over the frames.
    pub spheres: bool,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            curvature: 0.5,
            temporal: 0.0,
            inversion: true,
            spheres: true,
        }
    }
}

impl Options {
    /// The classic quadric error metric, for comparison.
    pub fn classic() -> Self {
        Self {
            curvature: 0.0,
            temporal: 0.0,
            inversion: true,
            spheres: false,
        }
    }
}
