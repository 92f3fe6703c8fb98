//! Regions of a mesh: colours that tell neighbours apart, and triangles cut where regions meet.

use glam::Vec3;

use super::colour;
use crate::{Error, Result};

/// Candidates for a region's colour.
const PALETTE: u16 = 24;

/// Linear RGB of each region, given the rows of its neighbours: of a fixed palette the colour that differs most from its
/// neighbours' and is used least.
pub fn region_colours<'a>(neighbours: impl ExactSizeIterator<Item = &'a [u32]>) -> Vec<Vec3> {
    let palette: Vec<Vec3> = (0..PALETTE).map(colour::bone_colour).collect();
    let mut uses = vec![0u32; palette.len()];
    let mut chosen: Vec<usize> = Vec::with_capacity(neighbours.len());
    for near in neighbours {
        let taken = near.iter().filter_map(|&n| chosen.get(n as usize));
        let taken: Vec<Vec3> = taken.map(|&k| perceived(palette[k])).collect();
        let worth = |k: usize| {
            let distances = taken.iter().map(|c| c.distance(perceived(palette[k])));
            // Beyond this two colours are told apart anyway.
            let apart = distances.fold(0.5, f32::min);
            apart - 0.05 * uses[k] as f32
        };
        let best =
            (0..palette.len()).max_by(|&a, &b| worth(a).total_cmp(&worth(b)).then(b.cmp(&a)));
        let best = best.unwrap_or(0);
        uses[best] += 1;
        chosen.push(best);
    }
    chosen.into_iter().map(|k| palette[k]).collect()
}

/// Differences of what this returns are closer to what is seen than those of linear light.
fn perceived(linear: Vec3) -> Vec3 {
    linear.powf(1.0 / 2.4)
}

/// A mesh whose vertices are of one region each, so that colours do not blend into each other.
#[derive(Clone, Debug, Default)]
pub struct Cut {
    /// Positions.
    pub positions: Vec<Vec3>,
    /// Unit normals, or zero where the given ones cancel out.
    pub normals: Vec<Vec3>,
    /// Colours, those of the regions.
    pub colours: Vec<Vec3>,
    /// Triangles as rows of the above, wound as the given ones.
    pub triangles: Vec<[u32; 3]>,
}

/// Cuts each triangle whose corners have different `labels` between them, along lines from the middles of its sides to its
/// own. Rows of positions, normals and labels are vertices; a label is a row of `colours`.
///
/// # Errors
/// [`Error::Argument`] for columns of different lengths, and naming a label without colour or a triangle without vertex.
pub fn cut_regions(
    positions: &[Vec3],
    normals: &[Vec3],
    labels: &[u32],
    triangles: &[[u32; 3]],
    colours: &[Vec3],
) -> Result<Cut> {
    check(positions.len(), normals, labels, triangles, colours)?;
    let of = |label: u32| colours[label as usize];
    let mut cut = Cut {
        positions: positions.to_vec(),
        normals: normals.to_vec(),
        colours: labels.iter().map(|&l| of(l)).collect(),
        triangles: Vec::new(),
    };
    for triangle in triangles {
        let corners = triangle.map(|v| labels[v as usize]);
        if corners[0] == corners[1] && corners[1] == corners[2] {
            cut.triangles.push(*triangle);
            continue;
        }
        for (k, &label) in corners.iter().enumerate() {
            let [a, b, c] = [0, 1, 2].map(|i| triangle[(k + i) % 3]);
            let mut middle = |of_these: &[u32]| cut.middle(of_these, of(label));
            let (ab, abc, ca) = (middle(&[a, b]), middle(&[a, b, c]), middle(&[c, a]));
            cut.triangles.extend([[a, ab, abc], [a, abc, ca]]);
        }
    }
    Ok(cut)
}

fn check(
    count: usize,
    normals: &[Vec3],
    labels: &[u32],
    triangles: &[[u32; 3]],
    colours: &[Vec3],
) -> Result<()> {
    for (name, rows) in [("normals", normals.len()), ("labels", labels.len())] {
        if rows != count {
            let reason = format!("{rows} rows for {count} vertices");
            return Err(Error::argument(name, reason));
        }
    }
    if let Some(row) = labels.iter().position(|&l| l as usize >= colours.len()) {
        let reason = format!("row {row} is {} of {}", labels[row], colours.len());
        return Err(Error::argument("labels", reason));
    }
    let outside = |t: &[u32; 3]| t.iter().any(|&v| v as usize >= count);
    if let Some(row) = triangles.iter().position(outside) {
        let reason = format!("{:?} of {count} vertices", triangles[row]);
        return Err(Error::argument(format!("triangle {row}"), reason));
    }
    Ok(())
}

impl Cut {
    /// A new vertex in the middle of some.
    fn middle(&mut self, of: &[u32], colour: Vec3) -> u32 {
        let mean = |rows: &[Vec3]| of.iter().map(|&v| rows[v as usize]).sum::<Vec3>();
        let (position, normal) = (mean(&self.positions) / of.len() as f32, mean(&self.normals));
        self.positions.push(position);
        self.normals.push(normal.normalize_or_zero());
        self.colours.push(colour);
        self.positions.len() as u32 - 1
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    #[test]
    fn neighbouring_regions_have_colours_of_their_own() {
        // A ring of 200, each with the two before and after it.
        let row = |i: u32| [i + 198, i + 199, i + 1, i + 2].map(|n| n % 200);
        let rows: Vec<[u32; 4]> = (0..200).map(row).collect();
        let colours = region_colours(rows.iter().map(|r| &r[..]));
        for (i, near) in rows.iter().enumerate() {
            for &n in near {
                let apart = perceived(colours[i]).distance(perceived(colours[n as usize]));
                assert!(apart > 0.15, "{i} {n}: {apart}");
            }
        }
    }

    #[test]
    fn cut_triangles_cover_the_same_area_in_one_colour_each() {
        let positions = [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::X + Vec3::Y];
        let colours = [Vec3::X, Vec3::Y, Vec3::Z];
        let triangles = [[0, 1, 2], [1, 3, 2]];
        let cut = cut_regions(
            &positions,
            &[Vec3::Z; 4],
            &[0, 1, 2, 2],
            &triangles,
            &colours,
        )
        .unwrap();
        let corner = |v: u32| cut.positions[v as usize];
        let area = |t: &[u32; 3]| {
            let [a, b, c] = t.map(corner);
            (b - a).cross(c - a).z / 2.0
        };
        assert_eq!(cut.triangles.len(), 12);
        assert!(cut.triangles.iter().all(|t| area(t) > 0.0));
        let of = |colour: Vec3| -> f32 {
            let own = |t: &&[u32; 3]| t.iter().all(|&v| cut.colours[v as usize] == colour);
            cut.triangles.iter().filter(own).map(area).sum()
        };
        let [a, b, c] = colours.map(of);
        for (found, expected) in [(a, 1.0 / 6.0), (b, 2.0 / 6.0), (c, 3.0 / 6.0)] {
            assert!((found - expected).abs() < 1e-6, "{a} {b} {c}");
        }
        assert!(cut.normals.iter().all(|n| *n == Vec3::Z));
        let whole = cut_regions(&positions, &[Vec3::Z; 4], &[1; 4], &triangles, &colours);
        assert_eq!(whole.unwrap().triangles, triangles);
    }

    #[test]
    fn what_does_not_fit_is_refused() {
        let refuse = |normals: usize, labels: &[u32], corner: u32| {
            let (positions, normals) = ([Vec3::ZERO; 3], vec![Vec3::Z; normals]);
            let cut = cut_regions(
                &positions,
                &normals,
                labels,
                &[[0, 1, corner]],
                &[Vec3::X; 2],
            );
            cut.unwrap_err().to_string()
        };
        assert!(refuse(2, &[0, 1, 0], 2).contains("normals: 2 rows for 3"));
        assert!(refuse(3, &[0, 1], 2).contains("labels: 2 rows for 3"));
        assert!(refuse(3, &[0, 1, 2], 2).contains("labels: row 2 is 2 of 2"));
        assert!(refuse(3, &[0, 1, 0], 3).contains("triangle 0: [0, 1, 3] of 3"));
    }
}
