//! A picture of a mesh before, bent plainly, and bent by each map.

use std::{fs, path::Path};

use dermis::{
    Error, Result,
    deformer::Device,
    gpu::{Gpu, GpuOptions},
    render::{
        self, Attributes, Background, Bounds, Camera, Picture, Projection, Renderer, Scene,
        Shading, View, sheet,
    },
};
use glam::{DVec3, Vec3};

use super::{Args, bender::Outcome, shape::Shape};
use crate::{output::Partial, png, session::check_validation};

/// A device that draws.
pub(super) struct Pictures {
    gpu: Gpu,
    renderer: Renderer,
    view: View,
}

impl Pictures {
    pub(super) fn open(args: &Args) -> Result<Self> {
        let options = GpuOptions {
            validation: args.validation,
            ..GpuOptions::default()
        };
        let gpu = Gpu::new(&options)?;
        Ok(Self {
            renderer: Renderer::new(&gpu, args.size.0, args.size.1)?,
            view: args.view,
            gpu,
        })
    }

    /// Draws all with one camera, each under its label.
    pub(super) fn draw(
        &mut self,
        name: &Path,
        partial: &Partial,
        shape: &Shape,
        bent: &[(&str, Outcome)],
    ) -> Result<()> {
        let turned = |rows: &[DVec3]| -> Vec<Vec3> {
            rows.iter().map(|v| shape.upright * v.as_vec3()).collect()
        };
        let rest = ("rest", &shape.positions, &shape.normals);
        let bent = bent
            .iter()
            .map(|(label, o)| (*label, &o.bent.positions, &o.bent.normals));
        let tile = |(label, positions, normals): (&str, &Vec<DVec3>, &Vec<DVec3>)| {
            (label.to_string(), turned(positions), turned(normals))
        };
        let tiles: Vec<_> = std::iter::once(rest).chain(bent).map(tile).collect();
        let bounds = tiles.iter().map(|(_, positions, _)| Bounds::of(positions));
        let bounds = bounds.reduce(|a, b| a.union(&b));
        let bounds = bounds.unwrap_or_else(|| Bounds::of(&[]));
        let projection = Projection::default();
        let camera = Camera::framing(&bounds, self.view, projection, self.renderer.aspect());
        let pictures = tiles
            .iter()
            .map(|(label, positions, normals)| {
                let picture = self.one(shape, positions, normals, camera)?;
                Ok((label, picture))
            })
            .collect::<Result<Vec<_>>>()?;
        let bytes = png::encode(name, &sheet(&pictures, pictures.len()))?;
        fs::write(partial.path(), bytes).map_err(|e| Error::file(name, e))?;
        check_validation(&Device::Gpu(self.gpu.clone()))
    }

    fn one(
        &mut self,
        shape: &Shape,
        positions: &[Vec3],
        normals: &[Vec3],
        camera: Camera,
    ) -> Result<Picture> {
        let attributes = Attributes {
            normals,
            field: &[],
            iso: &[],
            state: &[],
            bone: &[],
        };
        self.renderer.draw(&Scene {
            positions,
            normals,
            colours: &render::colours(Shading::Skin, &attributes)?,
            triangles: shape.triangles(),
            camera,
            wireframe: false,
            background: Background::default(),
        })
    }
}
