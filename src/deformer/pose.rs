//! A pose as the passes read it: palette of joints, posed fields, bounds of the index.

use std::mem::offset_of;

use bytemuck::{bytes_of, cast_slice};
use glam::{DMat3, DQuat, DVec3, Mat4, Vec3};

use super::{Settings, plan::Substep, statics::Statics};
use crate::{
    field::{AtlasLayout, GRID},
    layout::{CELLS, FieldPose, FieldsHead, JointPose, NO_MOTION, pack, pack_last_cell},
    rig::{Pose, Rig},
};

/// Stretches closer to the identity than this count as rigid.
const RIGID: f64 = 1e-5;

/// What an instance does in a slice of tracking, beside others.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Turn {
    /// Its last round of iterations, counted from the frame's beginning.
    pub(super) last_round: u32,
    /// Its skin is carried on; otherwise it has arrived.
    pub(super) carried: bool,
    /// Faults have the step done again in halves.
    pub(super) halves: bool,
    /// The furthest that any of its joints turns in the frame.
    pub(super) degrees: f32,
}

/// Uploads of one frame: a slice a sub-step and in it a part an instance. Its buffers are reused from frame to frame.
#[derive(Debug, Default)]
pub(super) struct PoseUpload {
    palette: Vec<JointPose>,
    fields: Vec<u8>,
    /// Parts of all slices so far.
    parts: usize,
    /// Parts of a slice.
    instances: usize,
    substeps: Vec<Substep>,
    /// Numbers of the motions of every joint in the last part, since the pose before and since rest.
    motions: Vec<[u32; 2]>,
    /// What carries the skin of the pose before to the last slice's.
    changes: Pose,
}

impl PoseUpload {
    /// With room for the largest frame, so that none allocates.
    pub(super) fn with_room(statics: &Statics, settings: &Settings) -> Self {
        let joints = statics.sizes.joints as usize;
        let slices = settings.max_slices() as usize;
        let parts = slices * settings.instances as usize;
        Self {
            palette: Vec::with_capacity(parts * joints),
            fields: Vec::with_capacity(parts * statics.fields_bytes()),
            substeps: Vec::with_capacity(slices),
            motions: Vec::with_capacity(joints),
            changes: Pose {
                matrices: Vec::with_capacity(joints),
            },
            ..Self::default()
        }
    }

    /// Bytes of [`super::Resource::PaletteRing`].
    pub(super) fn palette(&self) -> &[u8] {
        cast_slice(&self.palette)
    }

    /// Bytes of [`super::Resource::FieldsRing`].
    pub(super) fn fields(&self) -> &[u8] {
        &self.fields
    }

    /// Sub-steps; slices of halves follow those of the whole.
    pub(super) fn substeps(&self) -> &[Substep] {
        &self.substeps
    }

    /// The posed fields of the first instance in the last slice.
    pub(super) fn last_fields(&self) -> &[u8] {
        let bytes = self.fields.len() / self.parts.max(1);
        let first = self.parts.saturating_sub(self.instances.max(1)) * bytes;
        &self.fields[first..first + bytes]
    }

    /// One slice, from validated poses.
    pub(super) fn set(
        &mut self,
        rig: &Rig,
        statics: &Statics,
        layout: &AtlasLayout,
        poses: &[Pose],
    ) {
        self.clear(poses.len());
        for pose in poses {
            self.push(rig, statics, layout, None, pose);
        }
        self.substeps.push(Substep {
            rounds: 0,
            halves: false,
        });
    }

    /// A sub-step, whose slices have been pushed.
    pub(super) fn end_substep(&mut self, substep: Substep) {
        self.substeps.push(substep);
    }

    /// No slices.
    pub(super) fn clear(&mut self, instances: usize) {
        self.palette.clear();
        self.fields.clear();
        (self.parts, self.instances) = (0, instances);
        self.substeps.clear();
    }

    /// What the instance of the part added last does in its slice.
    pub(super) fn set_turn(&mut self, turn: Turn) {
        let flag = |x: bool| f32::from(u8::from(x));
        self.put_turn(&[
            turn.last_round as f32,
            flag(turn.carried),
            flag(turn.halves),
            turn.degrees,
        ]);
    }

    /// The first numbers of that.
    fn put_turn(&mut self, numbers: &[f32]) {
        let bytes = self.fields.len() / self.parts;
        let first = self.fields.len() - bytes + offset_of!(FieldsHead, turn);
        self.fields[first..first + size_of_val(numbers)].copy_from_slice(cast_slice(numbers));
    }

    /// Adds the part that the same instance has in the slice before, for one that has arrived.
    pub(super) fn repeat(&mut self) {
        let before = self.parts - self.instances;
        let joints = self.palette.len() / self.parts;
        let bytes = self.fields.len() / self.parts;
        let of = |length: usize| before * length..(before + 1) * length;
        self.palette.extend_from_within(of(joints));
        self.fields.extend_from_within(of(bytes));
        self.parts += 1;
        // It arrived by as large a turn.
        self.put_turn(&[0.0; 3]);
    }

    /// Adds a part from a validated pose. Motions and changes are since `before`, where there is one, else since rest.
    pub(super) fn push(
        &mut self,
        rig: &Rig,
        statics: &Statics,
        layout: &AtlasLayout,
        before: Option<&Pose>,
        pose: &Pose,
    ) {
        let first = self.palette.len();
        self.palette.extend(pose.matrices.iter().map(joint_pose));
        let added = &mut self.palette[first..];
        let mut changes = std::mem::take(&mut self.changes);
        match before {
            Some(before) => put_changes(before, pose, &mut changes),
            None => changes.clone_from(pose),
        }
        let stretched = added.iter().any(is_stretched);
        added[0].stretch1[3] = f32::from(u8::from(stretched));
        self.motions.clear();
        let since_rest = motions(rig, statics, pose);
        let both = motions(rig, statics, &changes).zip(since_rest);
        self.motions.extend(both.map(|(a, b)| [a, b]));
        let numbered = self.motions.iter().zip(&changes.matrices);
        for (joint, (motion, change)) in added.iter_mut().zip(numbered) {
            joint.set_motions(*motion);
            joint.change = rows(change);
        }
        self.changes = changes;
        self.fields
            .resize((self.parts + 1) * statics.fields_bytes(), 0);
        self.set_fields(rig, statics, layout, before, pose);
        self.parts += 1;
    }

    fn set_fields(
        &mut self,
        rig: &Rig,
        statics: &Statics,
        layout: &AtlasLayout,
        before: Option<&Pose>,
        pose: &Pose,
    ) {
        let texels = Vec3::from(layout.extent().map(|e| e as f32));
        let fields = rig.fields.len();
        let posed = statics
            .order
            .iter()
            .map(|row| to_model(rig, statics, pose, *row as usize));
        let (low, high) = posed
            .clone()
            .map(|m| extent(&m))
            .reduce(join)
            .unwrap_or((Vec3::ZERO, Vec3::ONE));
        let inverse = CELLS as f32 / (high - low).max(Vec3::splat(1e-6));
        let first_byte = self.parts * statics.fields_bytes();
        let head = first_byte + size_of::<FieldsHead>();
        for (i, to_model) in posed.enumerate() {
            let (first, last) = extent(&to_model);
            let cell = |p: Vec3| {
                ((p - low) * inverse)
                    .clamp(Vec3::ZERO, Vec3::splat(CELLS as f32 - 1.0))
                    .as_uvec3()
            };
            let row = statics.order[i];
            let [motion, since_rest] = self.motions(rig, statics, before, pose, row as usize);
            let field = FieldPose {
                rows: rows(&to_model.inverse()),
                tile: pack(layout.tile(row)) | motion << 24,
                link: statics.links[i],
                first_cell: pack(cell(first).to_array()) | since_rest << 24,
                last_cell: pack_last_cell(
                    cell(last).to_array(),
                    statics.carried[row as usize].joint as u16,
                ),
            };
            let at = head + i * size_of::<FieldPose>();
            self.fields[at..at + size_of::<FieldPose>()].copy_from_slice(bytes_of(&field));
        }
        let scales = statics
            .carried
            .iter()
            .map(|f| pose.matrices[f.joint as usize].determinant().abs().cbrt());
        let scale = if fields == 0 {
            1.0
        } else {
            scales.sum::<f32>() / fields as f32
        };
        let box_scale = Vec3::splat((GRID - 1) as f32) / texels;
        let content = FieldsHead {
            grid_origin: low.extend(statics.cell_words() as f32).to_array(),
            grid_inverse: inverse.extend(fields as f32).to_array(),
            box_scale: box_scale.extend(scale).to_array(),
            turn: [0.0, 1.0, 0.0, 0.0],
        };
        self.fields[first_byte..head].copy_from_slice(bytes_of(&content));
    }

    /// Numbers of a field's motions since the pose before and since rest: those of its joint, but a primitive that swells
    /// moves like nothing else.
    fn motions(
        &self,
        rig: &Rig,
        statics: &Statics,
        before: Option<&Pose>,
        pose: &Pose,
        row: usize,
    ) -> [u32; 2] {
        let mut motions = self.motions[statics.carried[row].joint as usize];
        if let Some(p) = rig.primitive(row) {
            for (motion, since) in motions.iter_mut().zip([before, None]) {
                if p.changes(&rig.skeleton, since, pose, statics.still) {
                    *motion = NO_MOTION;
                }
            }
        }
        motions
    }
}

/// Box coordinates → model space of a posed field; a primitive swells in rest space before its joint carries it.
fn to_model(rig: &Rig, statics: &Statics, pose: &Pose, row: usize) -> Mat4 {
    let field = &statics.carried[row];
    let joint = pose.matrices[field.joint as usize];
    match rig.primitive(row) {
        Some(p) => {
            let swell = p.matrix(p.stretch_in(&rig.skeleton, pose));
            joint * swell * field.to_rest
        }
        None => joint * field.to_rest,
    }
}

/// What carries the skin of one pose to another, a matrix a joint.
fn put_changes(from: &Pose, to: &Pose, changes: &mut Pose) {
    let pairs = from.matrices.iter().zip(&to.matrices);
    changes.matrices.clear();
    changes
        .matrices
        .extend(pairs.map(|(a, b)| *b * a.inverse()));
}

/// For every joint the first joint's field that moves as it does anywhere on the character.
fn motions(rig: &Rig, statics: &Statics, pose: &Pose) -> impl Iterator<Item = u32> {
    let (reach, still) = (statics.reach, statics.still);
    let of_field = |i: usize| &pose.matrices[statics.carried[i].joint as usize];
    pose.matrices.iter().map(move |joint| {
        let still = still_in(joint, still);
        let as_one = |i: &usize| moves_as(joint, of_field(*i), reach, still);
        let first = (0..rig.fields.len() - rig.primitives.len()).find(as_one);
        first.map_or(NO_MOTION, |i| i as u32)
    })
}

/// A distance in rest units where a motion carries it: a model that is smaller than its rest pose has smaller parts, too.
fn still_in(motion: &Mat4, still: f32) -> f32 {
    let axes = [motion.x_axis, motion.y_axis, motion.z_axis];
    still
        * axes
            .map(|axis| axis.length())
            .into_iter()
            .fold(f32::INFINITY, f32::min)
}

/// Two motions carry points up to `reach` from the origin, in rest units, to within `still` of each other.
fn moves_as(a: &Mat4, b: &Mat4, reach: f32, still: f32) -> bool {
    let apart = |k: usize| (a.col(k) - b.col(k)).abs().max_element();
    apart(3) <= still && apart(0).max(apart(1)).max(apart(2)) * reach + apart(3) <= still
}

/// Bounds of the unit cube carried by `m`, a little wider than rounding.
fn extent(m: &Mat4) -> (Vec3, Vec3) {
    let centre = m.transform_point3(Vec3::splat(0.5));
    let columns = [m.x_axis, m.y_axis, m.z_axis].map(|c| c.truncate().abs());
    let half = 0.5001 * (columns[0] + columns[1] + columns[2]);
    (centre - half, centre + half)
}

fn join(a: (Vec3, Vec3), b: (Vec3, Vec3)) -> (Vec3, Vec3) {
    (a.0.min(b.0), a.1.max(b.1))
}

fn rows(m: &Mat4) -> [[f32; 4]; 3] {
    [0, 1, 2].map(|r| m.row(r).to_array())
}

/// Splits a joint's matrix into rotation · stretch (polar decomposition) and a translation.
fn joint_pose(m: &Mat4) -> JointPose {
    let linear = DMat3::from_cols(
        m.x_axis.truncate().as_dvec3(),
        m.y_axis.truncate().as_dvec3(),
        m.z_axis.truncate().as_dvec3(),
    );
    let rotation = polar_rotation(&linear);
    let s = rotation.transpose() * linear;
    let s = if (s - DMat3::IDENTITY)
        .to_cols_array()
        .iter()
        .all(|x| x.abs() < RIGID)
    {
        DMat3::IDENTITY
    } else {
        s
    };
    let q = DQuat::from_mat3(&rotation).normalize();
    let t = m.w_axis.truncate().as_dvec3();
    let v = DVec3::new(q.x, q.y, q.z);
    let dual = (0.5 * (q.w * t + t.cross(v))).extend(-0.5 * t.dot(v));
    JointPose {
        rows: rows(m),
        real: q.as_quat().to_array(),
        dual: dual.as_vec4().to_array(),
        stretch0: [s.x_axis.x, s.y_axis.x, s.z_axis.x, 0.0].map(|x| x as f32),
        stretch1: [s.y_axis.y, s.z_axis.y, s.z_axis.z, 0.0].map(|x| x as f32),
        change: [[0.0; 4]; 3],
    }
}

/// Nearest rotation by Newton's iteration R ← (R + R⁻ᵀ)/2 (Higham 1986); of a mirror −m, so that the stretch is negative.
fn polar_rotation(m: &DMat3) -> DMat3 {
    let mut r = if m.determinant() < 0.0 { -*m } else { *m };
    for _ in 0..32 {
        let next = (r + r.inverse().transpose()) * 0.5;
        let moved = (next - r)
            .to_cols_array()
            .iter()
            .fold(0.0f64, |a, x| a.max(x.abs()));
        r = next;
        if moved < 1e-14 {
            break;
        }
    }
    r
}

fn is_stretched(joint: &JointPose) -> bool {
    joint.stretch0[..3] != [1.0, 0.0, 0.0] || joint.stretch1[..3] != [1.0, 0.0, 1.0]
}

#[cfg(test)]
mod tests {
    use glam::{Quat, Vec4};

    use super::*;
    use crate::twin::shared::rotation::rotate;

    fn carried(joint: &JointPose, p: Vec3) -> Vec3 {
        let (real, dual) = (Vec4::from_array(joint.real), Vec4::from_array(joint.dual));
        let (a, b) = (joint.stretch0, joint.stretch1);
        let stretched = Vec3::new(
            a[0] * p.x + a[1] * p.y + a[2] * p.z,
            a[1] * p.x + b[0] * p.y + b[1] * p.z,
            a[2] * p.x + b[1] * p.y + b[2] * p.z,
        );
        let shift = 2.0
            * (real.w * dual.truncate() - dual.w * real.truncate()
                + real.truncate().cross(dual.truncate()));
        rotate(real, stretched) + shift
    }

    #[test]
    fn motions_are_one_where_points_end_together_at_the_models_scale() {
        let moves_as = |a: &Mat4, b: &Mat4, reach, still| moves_as(a, b, reach, still_in(a, still));
        let turn = Mat4::from_rotation_x(0.3);
        let shifted = |by: f32| Mat4::from_translation(Vec3::X * by) * turn;
        assert!(moves_as(&turn, &shifted(0.5e-5), 2.0, 1e-5));
        assert!(!moves_as(&turn, &shifted(2e-5), 2.0, 1e-5));
        let turned = Mat4::from_rotation_x(0.3 + 1e-4);
        assert!(moves_as(&turn, &turned, 0.05, 1e-5));
        assert!(!moves_as(&turn, &turned, 2.0, 1e-5));
        let small = Mat4::from_scale(Vec3::splat(0.01));
        assert!(!moves_as(
            &(small * turn),
            &(small * shifted(2e-5)),
            2.0,
            1e-5
        ));
    }

    #[test]
    fn a_joint_pose_carries_points_as_its_matrix_does() {
        let turn = Quat::from_euler(glam::EulerRot::XYZ, 0.4, -1.1, 2.9);
        let rigid = Mat4::from_rotation_translation(turn, Vec3::new(1.0, -2.0, 0.5));
        let sheared = rigid
            * Mat4::from_cols_array(&[
                2.0, 0.1, 0.0, 0.0, 0.3, 1.5, 0.0, 0.0, 0.0, 0.0, 0.7, 0.0, 0.0, 0.2, 0.0, 1.0,
            ]);
        let mirrored = rigid * Mat4::from_scale(Vec3::new(-1.0, 1.0, 1.2));
        for m in [Mat4::IDENTITY, rigid, sheared, mirrored] {
            let joint = joint_pose(&m);
            for p in [Vec3::X, Vec3::new(0.3, -0.7, 1.1)] {
                assert!(
                    (carried(&joint, p) - m.transform_point3(p)).length() < 1e-5,
                    "{m}"
                );
            }
        }
        assert!(!is_stretched(&joint_pose(&rigid)));
        assert!(is_stretched(&joint_pose(&sheared)));
    }
}
