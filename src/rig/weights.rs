//! Weights of welded vertices, from the file or by heat diffusion, and the partition that follows from them.

use super::{Skeleton, Weights, heat::heat_weights};
use crate::{
    Error, Result,
    asset::{Influence, Model},
    mesh::Welded,
};

impl Weights {
    /// Gives lists of influences one width, the least multiple of four that holds all; lists are greatest first.
    pub fn from_lists(lists: &[Vec<Influence>]) -> Self {
        let longest = lists.iter().map(Vec::len).max().unwrap_or(0);
        let width = longest.max(1).next_multiple_of(4);
        let mut weights = Self {
            width,
            joints: vec![0; width * lists.len()],
            weights: vec![0.0; width * lists.len()],
        };
        for (v, list) in lists.iter().enumerate() {
            for (k, influence) in list.iter().enumerate() {
                weights.joints[v * width + k] = influence.joint;
                weights.weights[v * width + k] = influence.weight;
            }
        }
        weights
    }

    /// Joint of greatest weight of a vertex.
    pub fn dominant(&self, vertex: usize) -> u16 {
        self.joints[vertex * self.width]
    }

    /// Greatest weight of a vertex.
    pub fn greatest(&self, vertex: usize) -> f32 {
        self.weights[vertex * self.width]
    }
}

/// Weights of the welded vertices: those of a vertex's first row that has any, else (or where `force_heat`) by heat
/// diffusion. A note for the user comes with weights that had to be computed.
///
/// # Errors
/// [`Error::Argument`] where an influence names a joint that the skeleton has not or weights do not sum to 1.
pub(super) fn welded_weights(
    model: &Model,
    welded: &Welded,
    skeleton: &Skeleton,
    force_heat: bool,
) -> Result<(Weights, Vec<String>)> {
    let mut lists = vec![Vec::new(); welded.mesh.positions.len()];
    for (row, list) in model.influences.iter().enumerate() {
        check(row, list, skeleton)?;
        let slot: &mut Vec<Influence> = &mut lists[welded.vertex[row] as usize];
        if slot.is_empty() && !force_heat {
            slot.clone_from(list);
        }
    }
    let missing: Vec<bool> = lists.iter().map(Vec::is_empty).collect();
    let count = missing.iter().filter(|m| **m).count();
    let mut notes = Vec::new();
    if count > 0 {
        let heat = heat_weights(&welded.mesh, skeleton, &missing);
        for (list, heated) in lists.iter_mut().zip(heat) {
            if list.is_empty() {
                *list = heated;
            }
        }
        notes.push(format!(
            "{count} of {} vertices have weights by heat diffusion",
            lists.len()
        ));
    }
    Ok((Weights::from_lists(&lists), notes))
}

fn check(row: usize, list: &[Influence], skeleton: &Skeleton) -> Result<()> {
    let refuse = |reason: String| {
        Err(Error::argument(
            format!("influences of vertex {row}"),
            reason,
        ))
    };
    let count = skeleton.joints.len();
    if let Some(bad) = list.iter().find(|i| usize::from(i.joint) >= count) {
        return refuse(format!("joint {} of {count}", bad.joint));
    }
    if list.is_empty() {
        return Ok(());
    }
    let sum: f32 = list.iter().map(|i| i.weight).sum();
    let positive = list.iter().all(|i| i.weight > 0.0);
    if !positive || (sum - 1.0).abs() > 1e-3 {
        return refuse(format!("weights must be positive and sum to 1, not {sum}"));
    }
    if !list.is_sorted_by(|a, b| a.weight >= b.weight) {
        return refuse("the greatest must come first".into());
    }
    Ok(())
}

/// Part of each welded vertex: the given one of its first row, else its joint of greatest weight.
///
/// # Errors
/// [`Error::Argument`] where `given` has not one joint row a row of the file, or one is out of range.
pub(super) fn partition(
    welded: &Welded,
    weights: &Weights,
    skeleton: &Skeleton,
    given: Option<&[u16]>,
) -> Result<Vec<u16>> {
    let vertices = welded.mesh.positions.len();
    let Some(given) = given else {
        return Ok((0..vertices).map(|v| weights.dominant(v)).collect());
    };
    let rows = welded.vertex.len();
    if given.len() != rows {
        let reason = format!("{} given, there are {rows} vertices", given.len());
        return Err(Error::argument("part", reason));
    }
    let joints = skeleton.joints.len();
    if let Some(row) = given.iter().position(|j| usize::from(*j) >= joints) {
        let reason = format!("joint {} at vertex {row}, there are {joints}", given[row]);
        return Err(Error::argument("part", reason));
    }
    let first = welded.first_rows();
    Ok(first.iter().map(|row| given[*row as usize]).collect())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::{mesh::weld, rig::skeleton::tests::skeleton};
    use glam::Vec3;

    fn influence(joint: u16, weight: f32) -> Influence {
        Influence { joint, weight }
    }

    fn seam() -> (Model, Welded) {
        let model = Model {
            positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::ZERO],
            triangles: vec![[0, 1, 2], [3, 2, 1]],
            influences: vec![
                vec![influence(1, 0.7), influence(0, 0.3)],
                vec![influence(2, 1.0)],
                (0..4).chain([0]).map(|j| influence(j, 0.2)).collect(),
                vec![influence(3, 1.0)],
            ],
            ..Model::default()
        };
        let welded = weld(&model.positions, &model.triangles);
        (model, welded)
    }

    #[test]
    fn first_row_wins_and_width_grows_by_fours() {
        let (model, welded) = seam();
        let (w, notes) = welded_weights(&model, &welded, &skeleton(), false).unwrap();
        assert_eq!(w.width, 8);
        assert_eq!(w.joints[..2], [1, 0]);
        assert_eq!(w.weights[..3], [0.7, 0.3, 0.0]);
        assert!(notes.is_empty());
        let part = partition(&welded, &w, &skeleton(), None).unwrap();
        assert_eq!(part, [1, 2, 0]);
        let given = partition(&welded, &w, &skeleton(), Some(&[3, 2, 1, 0])).unwrap();
        assert_eq!(given, [3, 2, 1]);
    }

    #[test]
    fn wrong_influences_and_parts_are_refused() {
        let (mut model, welded) = seam();
        let s = skeleton();
        let (w, _) = welded_weights(&model, &welded, &s, false).unwrap();
        assert!(partition(&welded, &w, &s, Some(&[0, 0])).is_err());
        assert!(partition(&welded, &w, &s, Some(&[0, 0, 9, 0])).is_err());
        for bad in [
            vec![influence(9, 1.0)],
            vec![influence(0, f32::NAN)],
            vec![influence(0, 0.3)],
            vec![influence(0, 0.3), influence(1, 0.7)],
        ] {
            model.influences[1] = bad;
            let error = welded_weights(&model, &welded, &s, false).unwrap_err();
            assert!(error.to_string().contains("vertex 1"));
        }
    }
}
