//! A picture of a mesh before, bent plainly, and bent by a map.

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

use super::{bender::Outcome, shape::Shape};
use crate::{options::DeviceOptions, output::Partial, png, session::check_validation};

const SIZE: u32 = 560;

/// A device that draws.
pub(super) struct Pictures {
    gpu: Gpu,
    renderer: Renderer,
}

impl Pictures {
    pub(super) fn open(options: &DeviceOptions) -> Result<Self> {
        let options = GpuOptions {
            validation: options.validation,
            ..GpuOptions::default()
        };
        let gpu = Gpu::new(&options)?;
        Ok(Self {
            renderer: Renderer::new(&gpu, SIZE, SIZE)?,
            gpu,
        })
    }

    /// Draws all three with one camera.
    pub(super) fn draw(
        &mut self,
        name: &Path,
        partial: &Partial,
        shape: &Shape,
        [plain, map]: [&Outcome; 2],
        label: &str,
    ) -> Result<()> {
        let turned = |rows: &[DVec3]| -> Vec<Vec3> {
            rows.iter().map(|v| shape.upright * v.as_vec3()).collect()
        };
        let tiles = [
            ("rest", &shape.positions, &shape.normals),
            ("plain", &plain.bent.positions, &plain.bent.normals),
            (label, &map.bent.positions, &map.bent.normals),
        ]
        .map(|(label, positions, normals)| (label, turned(positions), turned(normals)));
        let bounds = tiles.iter().map(|(_, positions, _)| Bounds::of(positions));
        let bounds = bounds.reduce(|a, b| a.union(&b));
        let bounds = bounds.unwrap_or_else(|| Bounds::of(&[]));
        let projection = Projection::default();
        let view = View::default();
        let camera = Camera::framing(&bounds, view, projection, self.renderer.aspect());
        let pictures = tiles
            .iter()
            .map(|(label, positions, normals)| {
                let picture = self.one(shape, positions, normals, camera)?;
                Ok((*label, picture))
            })
            .collect::<Result<Vec<_>>>()?;
        let bytes = png::encode(name, &sheet(&pictures, 3))?;
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
