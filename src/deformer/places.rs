//! Where the last frame samples its fields, for measurements that take the same samples and do nothing else.

use bytemuck::cast_slice;
use glam::{Vec3, Vec4};

use super::{Deformer, Machine, Resource, plan::dispatch_rows};
use crate::{
    Result,
    layout::{FieldPose, FieldsHead, unpack},
};

/// Places of an atlas.
#[derive(Clone, Debug, Default)]
pub struct Places {
    /// Texels along x, y, z.
    pub extent: [u32; 3],
    /// Half-float RGBA texels, x fastest.
    pub texels: Vec<u8>,
    /// Texture coordinates, vertex by vertex in the order of the projection; w is 0.
    pub places: Vec<[f32; 4]>,
}

impl Deformer {
    /// Samples that the projection of the first instance's last pose takes in one evaluation at the places where its vertices ended: one for
    /// every field whose box holds the vertex. None for methods without a projection. Waits for the frame.
    ///
    /// # Errors
    /// Vulkan errors.
    pub fn places(&mut self) -> Result<Places> {
        if !self.settings.method.has_fields() {
            return Ok(Places::default());
        }
        let positions = self.machine.read::<[f32; 4]>(Resource::Positions)?;
        let rows = dispatch_rows(self.settings()) as usize;
        let heads = &self.machine.heads(Resource::SeedDispatches, rows)?[0];
        let seeds = self.machine.read::<u32>(Resource::SeedList)?;
        let head = size_of::<FieldsHead>();
        let fields: FieldsHead = bytemuck::pod_read_unaligned(&self.upload.last_fields()[..head]);
        let poses: &[FieldPose] = cast_slice(&self.upload.last_fields()[head..]);
        let scale = Vec3::from_slice(&fields.box_scale);
        let mut places = Vec::new();
        for &v in &seeds[..heads.counts(0)[0] as usize] {
            let x = Vec3::from_slice(&positions[v as usize]);
            let held = poses[..self.rig.fields.len()].iter();
            places.extend(held.filter_map(|pose| place(pose, x, scale)));
        }
        let (extent, texels) = self.atlas()?;
        Ok(Places {
            extent,
            texels,
            places,
        })
    }

    fn atlas(&self) -> Result<([u32; 3], Vec<u8>)> {
        match &self.machine {
            Machine::Cpu(m) => {
                let atlas = &m.store.atlas;
                Ok((atlas.extent, cast_slice(&atlas.texels).to_vec()))
            }
            Machine::Gpu(m) => m.resources.atlas(&m.gpu),
        }
    }
}

/// Texture coordinates of `x` in a field's tile, where its box holds `x` (`shaders/shared/field.glsl`, `sample_field`).
fn place(pose: &FieldPose, x: Vec3, scale: Vec3) -> Option<[f32; 4]> {
    let rows = pose.rows.map(Vec4::from_array);
    let at = Vec3::from_array(rows.map(|r| r.truncate().dot(x) + r.w));
    let tile = (Vec3::from(unpack(pose.tile).map(|t| t as f32)) * 32.0 + 0.5) / 31.0;
    (at == at.clamp(Vec3::ZERO, Vec3::ONE)).then(|| ((tile + at) * scale).extend(0.0).to_array())
}
