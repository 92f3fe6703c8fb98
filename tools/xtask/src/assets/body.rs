//! From a shape and bones to a character.

use dermis::asset::Model;
use glam::DVec3;

use super::{
    grid::surface_nets,
    motion::Bones,
    shape::{Shape, put_skin},
    surface::fair,
    weights::diffused,
};
use crate::Result;

/// A character but for its clips.
pub(crate) struct Body {
    /// File name without extension.
    pub(crate) name: &'static str,
    /// Linear base colour.
    pub(crate) color: [f32; 3],
    /// Skin.
    pub(crate) shape: Shape,
    /// Joints.
    pub(crate) bones: Bones,
    /// Box that holds the shape.
    pub(crate) bounds: [DVec3; 2],
    /// Length of an edge in metres; decides how many vertices there are.
    pub(crate) spacing: f64,
    /// Rounds of diffusion: weights change over about the root of this number of edges.
    pub(crate) softness: usize,
}

impl Body {
    /// Skins the shape.
    pub(crate) fn model(&self) -> Result<Model> {
        let [low, high] = self.bounds;
        let quads = surface_nets(&self.shape, low, high, self.spacing)?;
        let surface = fair(&self.shape, quads, 15)?;
        let joint: Vec<usize> = surface
            .positions
            .iter()
            .map(|p| self.shape.joint(*p))
            .collect();
        let mut model = Model {
            path: format!("{}.glb", self.name).into(),
            ..Model::default()
        };
        model.influences = diffused(
            &joint,
            self.bones.0.len(),
            &surface.neighbours,
            self.softness,
        );
        let [r, g, b] = self.color;
        put_skin(
            &mut model,
            [r, g, b, 1.0],
            &surface.positions,
            &surface.normals,
            surface.triangles,
        );
        self.bones.put(&mut model);
        Ok(model)
    }
}
