//! Where the skin is rigid: as painted in the file, and the parts of the joints that the user names.

use super::Skeleton;
use crate::{Error, Result, mesh::Welded};

/// Rigidity of each welded vertex: the greatest of its rows; 0 everywhere where `rows` is empty.
pub(super) fn welded_rigid(rows: &[f32], welded: &Welded) -> Vec<f32> {
    let mut rigid = vec![0.0_f32; welded.mesh.positions.len()];
    for (row, vertex) in rows.iter().zip(&welded.vertex) {
        let slot = &mut rigid[*vertex as usize];
        *slot = slot.max(*row);
    }
    rigid
}

/// Makes the parts of the named joints rigid: relaxation is not wanted there (2014, section 6.2 and figure 11).
///
/// # Errors
/// [`Error::Joint`] for a joint that the skeleton has not or whose part is empty.
pub(super) fn stiffen(
    rigid: &mut [f32],
    part: &[u16],
    skeleton: &Skeleton,
    names: &[String],
) -> Result<()> {
    for name in names {
        let joint = skeleton.find(name)?;
        let mut any = false;
        for (slot, _) in rigid
            .iter_mut()
            .zip(part)
            .filter(|(_, p)| usize::from(**p) == joint)
        {
            *slot = 1.0;
            any = true;
        }
        if !any {
            return Err(Error::Joint {
                joint: name.clone(),
                reason: "it has no skin of its own to make rigid".into(),
            });
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::{mesh::weld, rig::skeleton::tests::skeleton};
    use glam::Vec3;

    #[test]
    fn a_seam_is_as_rigid_as_its_most_rigid_row() {
        let p = [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::ZERO, Vec3::X];
        let welded = weld(&p, &[[0, 1, 2], [3, 2, 4]]);
        let rows = [0.25, 0.5, 0.0, 1.0, 0.0];
        assert_eq!(welded_rigid(&rows, &welded), [1.0, 0.5, 0.0]);
        assert_eq!(welded_rigid(&[], &welded), [0.0; 3]);
    }

    #[test]
    fn a_joints_part_becomes_rigid_and_bad_joints_are_named() {
        let (s, part) = (skeleton(), [0, 1, 1, 2]);
        let mut rigid = vec![0.0, 0.5, 0.0, 0.25];
        stiffen(&mut rigid, &part, &s, &[s.joints[1].name.clone()]).unwrap();
        assert_eq!(rigid, [0.0, 1.0, 1.0, 0.25]);
        for name in ["knee", &s.joints[3].name] {
            let error = stiffen(&mut rigid, &part, &s, &[name.into()]).unwrap_err();
            assert!(matches!(&error, Error::Joint { joint, .. } if joint == name));
        }
    }
}
