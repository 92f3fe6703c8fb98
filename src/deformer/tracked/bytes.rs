//! A tracked state as bytes, for hosts that keep it beside their own.

use bytemuck::{Pod, cast_slice, pod_collect_to_vec};
use glam::Mat4;

use super::TrackedState;
use crate::{Error, Result, rig::Pose};

/// First word; another byte order reads it otherwise.
const MAGIC: u32 = 0x7464_6d32;

/// Words before the arrays: magic, joints, vertices.
const HEAD: usize = 12;

/// Bytes of a joint's matrix.
const JOINT: usize = size_of::<[f32; 16]>();

/// Bytes of a vertex: four rows of four floats and a word.
const VERTEX: usize = 4 * size_of::<[f32; 4]>() + size_of::<u32>();

impl TrackedState {
    /// The state as bytes, for this version of the library on machines of this byte order.
    pub fn to_bytes(&self) -> Vec<u8> {
        let pose = self.pose.as_ref().map_or(&[][..], |pose| &pose.matrices);
        let head = [MAGIC, pose.len() as u32, self.tracked.len() as u32];
        let mut bytes = cast_slice::<_, u8>(&head).to_vec();
        bytes.extend_from_slice(cast_slice(pose));
        for rows in [&self.tracked, &self.before, &self.slopes, &self.corrections] {
            bytes.extend_from_slice(cast_slice(rows));
        }
        bytes.extend_from_slice(cast_slice(&self.around));
        bytes
    }

    /// A state from what [`TrackedState::to_bytes`] gave. Whether it fits a character is told by
    /// [`Deformer::restore`](crate::deformer::Deformer::restore).
    ///
    /// # Errors
    /// [`Error::Argument`] with subject `state` where the bytes are no state of this version.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self> {
        let refuse = || Error::argument("state", "these bytes are no state of this version");
        let (head, rest) = bytes.split_at_checked(HEAD).ok_or_else(refuse)?;
        let head: Vec<u32> = pod_collect_to_vec(head);
        let (joints, vertices) = (head[1] as usize, head[2] as usize);
        let wanted = (joints as u64 * JOINT as u64).checked_add(vertices as u64 * VERTEX as u64);
        if head[0] != MAGIC || wanted != Some(rest.len() as u64) {
            return Err(refuse());
        }
        let mut reader = Reader(rest);
        let matrices: Vec<[f32; 16]> = reader.take(joints);
        let matrices = matrices.iter().map(Mat4::from_cols_array).collect();
        Ok(Self {
            pose: (joints > 0).then_some(Pose { matrices }),
            tracked: reader.take(vertices),
            before: reader.take(vertices),
            slopes: reader.take(vertices),
            corrections: reader.take(vertices),
            around: reader.take(vertices),
        })
    }
}

/// Bytes whose length has been checked.
struct Reader<'a>(&'a [u8]);

impl Reader<'_> {
    fn take<T: Pod>(&mut self, count: usize) -> Vec<T> {
        let (taken, rest) = self.0.split_at(count * size_of::<T>());
        self.0 = rest;
        pod_collect_to_vec(taken)
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    fn state(pose: Option<Pose>) -> TrackedState {
        TrackedState {
            pose,
            tracked: vec![[1.0; 4], [2.0; 4]],
            before: vec![[3.0; 4], [4.0; 4]],
            slopes: vec![[5.0; 4], [6.0; 4]],
            corrections: vec![[7.0; 4], [8.0; 4]],
            around: vec![9, 10],
        }
    }

    #[test]
    fn a_state_comes_back_from_its_bytes() {
        let pose = Pose {
            matrices: vec![Mat4::IDENTITY, Mat4::from_rotation_x(0.5)],
        };
        for state in [state(None), state(Some(pose))] {
            let bytes = state.to_bytes();
            assert_eq!(TrackedState::from_bytes(&bytes).unwrap(), state);
        }
    }

    #[test]
    fn other_bytes_are_refused() {
        let bytes = state(None).to_bytes();
        let mut longer = bytes.clone();
        longer.push(0);
        let mut other = bytes.clone();
        other[0] ^= 1;
        let many = [MAGIC, u32::MAX, u32::MAX];
        for bad in [
            &[][..],
            &bytes[..bytes.len() - 1],
            &longer,
            &other,
            cast_slice(&many),
        ] {
            assert!(TrackedState::from_bytes(bad).is_err());
        }
    }
}
