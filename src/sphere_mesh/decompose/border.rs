//! Where the regions of two spheres meet.

use std::collections::BTreeMap;

use glam::DVec3;

/// The border of two regions.
pub(super) struct Border {
    /// Spheres, ascending.
    pub(super) spheres: [usize; 2],
    /// Its middle, at rest: within a limb, the middle of its cross-section.
    pub(super) middle: DVec3,
    /// Vertices on it, those of several triangles as often.
    pub(super) size: f64,
}

/// All borders; `labels` are the vertices' spheres.
pub(super) fn borders(triangles: &[[u32; 3]], labels: &[u32], rest: &[DVec3]) -> Vec<Border> {
    let mut sums = BTreeMap::<[usize; 2], (DVec3, f64)>::new();
    for t in triangles {
        for k in 0..3 {
            let ends = [t[k], t[(k + 1) % 3]].map(|v| v as usize);
            let mut spheres = ends.map(|v| labels[v] as usize);
            spheres.sort_unstable();
            if spheres[0] != spheres[1] {
                let sum = sums.entry(spheres).or_default();
                sum.0 += rest[ends[0]] + rest[ends[1]];
                sum.1 += 2.0;
            }
        }
    }
    let border = |(spheres, (sum, size)): ([usize; 2], (DVec3, f64))| Border {
        spheres,
        middle: sum / size,
        size,
    };
    sums.into_iter().map(border).collect()
}
