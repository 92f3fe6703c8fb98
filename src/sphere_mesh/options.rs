//! How a sphere-mesh is built.

/// Settings of a build.
#[derive(Clone, Debug)]
pub struct Options {
    /// Percentile, 0 to 100, at which curvature is clamped where it decides how much a vertex counts; without it every
    /// vertex counts by its area alone. Curvature spans many orders of magnitude, and a few slivers must not outvote the rest.
    pub curvature: Option<f64>,
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
            curvature: Some(80.0),
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
            curvature: None,
            temporal: 0.0,
            inversion: true,
            spheres: false,
        }
    }
}
