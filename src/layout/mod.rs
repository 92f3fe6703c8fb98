//! Structs that shaders share (`shaders/shared/types.glsl`): same names, same fields, same order, std430/std140 layout.

pub mod field_grid;
pub mod particles;

use bytemuck::{Pod, Zeroable};

/// Greatest number of fields: their numbers are those of motions, too, and [`NO_MOTION`] is none.
pub const MAX_FIELDS: usize = 255;

/// Cells of the index along an axis.
pub const CELLS: u32 = 32;

/// Rows of an opening curve's table.
pub const OPENING_ROWS: usize = 128;

/// "No parent field" in [`FieldPose::link`].
pub const NO_FIELD: u32 = 0xffff;

/// Number of a motion that no field has. Joints and fields with the same number move as one.
pub const NO_MOTION: u32 = 255;

/// Numbers of motions, [`NO_MOTION`] among them.
pub const MOTIONS: u32 = 256;

/// "No seed": geometric skinning only.
pub const NO_SEED: u32 = u32::MAX;

/// Seeds of a block of a set: 32 words of bits.
pub const SET_SEEDS: usize = 1024;

/// Words of a block of a set: its bits, and how many are set.
pub const SET_BLOCK: usize = 33;

/// How shaders compose fields: their specialization constant 0.
pub mod composition {
    /// Every joint is a union.
    pub const UNIONS: u32 = 0;
    /// Operators at joints, then the greatest of all.
    pub const OPERATORS: u32 = 1;
    /// Contacts from leaf to leaf (2014).
    pub const CONTACTS: u32 = 2;
    /// The same with groups of bulges below.
    pub const GROUPS: u32 = 3;
}

/// States of a vertex.
pub mod state {
    /// Geometric skinning only.
    pub const UNTOUCHED: u32 = 0;
    /// On its iso-value.
    pub const ON_ISO: u32 = 1;
    /// Stopped in contact.
    pub const CONTACT: u32 = 2;
    /// Outside every field.
    pub const OUTSIDE: u32 = 3;
    /// Stopped by the iteration limit or, in tracking, on its way to where it settles.
    pub const LIMIT: u32 = 4;
    /// Past the limit of the map of its spine (2013, Eqs. 9, 13, 17).
    pub const PAST_LIMIT: u32 = 5;
    /// Still on its way; only while a frame runs.
    pub const LIVE: u32 = 6;

    /// State in a status word.
    pub fn of(status: u32) -> u32 {
        status & 0xff
    }

    /// Field evaluations in a status word, saturated at 255.
    pub fn evaluations(status: u32) -> u32 {
        (status >> 8) & 0xff
    }

    /// Texture fetches in a status word, saturated at 32767.
    pub fn fetches(status: u32) -> u32 {
        (status >> 16) & 0x7fff
    }

    /// Bit of a status word: the vertex went sideways out of a deep fold.
    pub const STRAYED: u32 = 0x8000_0000;
}

/// A welded vertex at rest.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct Vertex {
    /// Rest position.
    pub position: [f32; 3],
    /// Radius of its part in rest units.
    pub radius: f32,
    /// Smooth normal at rest.
    pub normal: [f32; 3],
    /// Joint row of its part, as a number: texels may lose the bits of small integers.
    pub part: f32,
}

/// A posed joint: rest → model space as a matrix, and as stretch followed by a dual quaternion.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct JointPose {
    /// Rows of the matrix.
    pub rows: [[f32; 4]; 3],
    /// Rotation, xyzw.
    pub real: [f32; 4],
    /// Dual part of the dual quaternion, xyzw.
    pub dual: [f32; 4],
    /// Symmetric stretch: xx xy xz; the numbers of its motions, as [`JointPose::set_motions`] joins them.
    pub stretch0: [f32; 4],
    /// Symmetric stretch: yy yz zz; w of joint 0: any joint is not rigid.
    pub stretch1: [f32; 4],
    /// Rows of the change since the pose before, model → model space.
    pub change: [[f32; 4]; 3],
}

impl JointPose {
    /// Sets the numbers of its motions since the pose before and since rest, both at most [`NO_MOTION`].
    pub fn set_motions(&mut self, [before, rest]: [u32; 2]) {
        self.stretch0[3] = (before + MOTIONS * rest) as f32;
    }

    /// These numbers.
    pub fn motions(&self) -> [u32; 2] {
        let both = self.stretch0[3] as u32;
        [both % MOTIONS, both / MOTIONS]
    }
}

/// A posed field.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct FieldPose {
    /// Rows of model space → box coordinates.
    pub rows: [[f32; 4]; 3],
    /// Its tile in the atlas: x | y << 8 | z << 16 | number of its motion since the pose before << 24.
    pub tile: u32,
    /// Parent field | operator volume (from 1, 0 for the union) << 16 | opening curve << 24; in tracking, group | controller
    /// against the groups before << 8 | operator volume in the group << 16 | its controller << 24.
    pub link: u32,
    /// First index cell that its box may meet: x | y << 8 | z << 16 | number of its motion since rest << 24.
    pub first_cell: u32,
    /// Last index cell that its box may meet, and its joint, as [`pack_last_cell`] joins them.
    pub last_cell: u32,
}

/// A row of the file that follows a spine: [`crate::rig::FleshPlace`] with the row's normal.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct FleshRow {
    /// Unit tangent of the rest spine; w: length of the rest spine a unit of its parameter.
    pub tangent: [f32; 4],
    /// First vector of the frame; w: how far past an end.
    pub side: [f32; 4],
    /// Place across the straight spine; weight; derivative of the logarithm of the speed.
    pub straight: [f32; 4],
    /// The normal times the derivatives of the rest position by arc length and by both coordinates of `straight`; w: share of
    /// the second joint.
    pub covector: [f32; 4],
    /// The two joints whose rotations blend, as numbers; the share's derivative; the map: 0 radial, 1 normal, 2 binormal.
    pub frame: [f32; 4],
    /// Derivative of the rest spine's unit tangent by its parameter, along side and tangent × side; 0, 0.
    pub turning: [f32; 4],
    /// Row of the file, that of its first weight, that of its spine's first point, and the number of points.
    pub rows: [u32; 4],
}

/// Head of the posed fields of an instance; [`FieldPose`]s follow.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct FieldsHead {
    /// Corner of the index in model space; w: words of a cell, an even number.
    pub grid_origin: [f32; 4],
    /// Cells a model unit; w: number of fields.
    pub grid_inverse: [f32; 4],
    /// Texture coordinates a box coordinate; w: model units a rest unit.
    pub box_scale: [f32; 4],
    /// What an instance does beside others in tracking: its last round of iterations, counted from the frame's beginning; 1
    /// where the skin is carried on, 0 where it has arrived; 1 where faults have the step done again in halves; the degrees that any of its joints turns
    /// in the frame at most.
    pub turn: [f32; 4],
}

/// Three numbers below 256 in a word.
pub fn pack(xyz: [u32; 3]) -> u32 {
    xyz[0] | xyz[1] << 8 | xyz[2] << 16
}

/// The three numbers of [`pack`].
pub fn unpack(word: u32) -> [u32; 3] {
    [word & 0xff, word >> 8 & 0xff, word >> 16 & 0xff]
}

/// The last index cell of a field's box, and the field's joint: x | y << 5 | z << 10 | joint << 16.
pub fn pack_last_cell(xyz: [u32; 3], joint: u16) -> u32 {
    xyz[0] | xyz[1] << 5 | xyz[2] << 10 | u32::from(joint) << 16
}

/// The cell and the joint of [`pack_last_cell`].
pub fn unpack_last_cell(word: u32) -> ([u32; 3], u32) {
    (
        [word & 0x1f, word >> 5 & 0x1f, word >> 10 & 0x1f],
        word >> 16,
    )
}

/// Head of a work list of one instance.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
pub struct Dispatch {
    /// Workgroups for an indirect dispatch.
    pub groups: [u32; 3],
    /// Items of the list.
    pub count: u32,
}

impl Dispatch {
    /// Head of a list of `count` items, 64 a workgroup.
    pub fn of(count: usize) -> Self {
        let count = count as u32;
        Self {
            groups: [count.div_ceil(64), 1, 1],
            count,
        }
    }
}
