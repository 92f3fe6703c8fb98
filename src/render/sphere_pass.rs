//! Draws spheres, cones and slabs: the device finds where rays meet them.

use bytemuck::{Pod, Zeroable};
use glam::{Mat4, Vec4};

use super::{Camera, Projection, Spheres, renderer::filled};
use crate::{
    Result,
    gpu::{
        Buffer, Gpu,
        raster::{Canvas, Draw, Pipeline, Shaders},
    },
};

const SPHERES: Shaders = Shaders {
    name: "spheres",
    vertex: include_bytes!("../../shaders/spirv/spheres.vert.spv"),
    fragment: include_bytes!("../../shaders/spirv/spheres.frag.spv"),
    buffers: 3,
    constants: size_of::<Constants>() as u32,
    depth: true,
    blend: true,
    each_sample: true,
};

/// Names of the vertex shader's storage buffers, in the order of its bindings.
const BUFFERS: [&str; 3] = ["render.balls", "render.ball_colours", "render.primitives"];

/// Corners of a primitive: two triangles.
const CORNERS: u32 = 6;

/// Push constants of `spheres.vert` and `spheres.frag`.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct Constants {
    clip_from_model: Mat4,
    eye: Vec4,
    right: Vec4,
    up: Vec4,
    pixel: Vec4,
}

/// The pipeline and its buffers, which are kept between pictures.
pub(super) struct SpherePass {
    pipeline: Pipeline,
    buffers: [Option<Buffer>; 3],
}

/// What a picture has of spheres, on the device.
pub(super) struct Bound<'a> {
    pipeline: &'a Pipeline,
    buffers: Vec<&'a Buffer>,
    constants: Constants,
    vertices: u32,
}

impl SpherePass {
    pub(super) fn new(canvas: &Canvas) -> Result<Self> {
        Ok(Self {
            pipeline: canvas.pipeline(&SPHERES)?,
            buffers: [const { None }; 3],
        })
    }

    /// Uploads what is to be seen by `camera` in a picture of `size` pixels.
    pub(super) fn bind(
        &mut self,
        gpu: &Gpu,
        spheres: &Spheres,
        camera: &Camera,
        size: (u32, u32),
    ) -> Result<Bound<'_>> {
        let primitives = spheres.ordered(camera);
        let rows: [&[u8]; 3] = [
            bytemuck::cast_slice(&spheres.balls),
            bytemuck::cast_slice(&spheres.colours),
            bytemuck::cast_slice(&primitives),
        ];
        let mut buffers = Vec::with_capacity(rows.len());
        for ((slot, name), bytes) in self.buffers.iter_mut().zip(BUFFERS).zip(rows) {
            buffers.push(filled(gpu, slot, name, bytes)?);
        }
        Ok(Bound {
            pipeline: &self.pipeline,
            buffers,
            constants: constants(camera, size),
            vertices: CORNERS * primitives.len() as u32,
        })
    }
}

impl Bound<'_> {
    pub(super) fn draw(&self) -> Draw<'_> {
        Draw {
            pipeline: self.pipeline,
            buffers: &self.buffers,
            constants: bytemuck::bytes_of(&self.constants),
            vertices: self.vertices,
        }
    }
}

fn constants(camera: &Camera, (width, height): (u32, u32)) -> Constants {
    let (width, height) = (width as f32, height as f32);
    let [right, up, _] = camera.axes();
    let (half_height, meet) = match camera.projection {
        Projection::Perspective { degrees } => ((degrees.to_radians() / 2.0).tan(), 1.0),
        Projection::Orthographic { height } => (height / 2.0, 0.0),
    };
    Constants {
        clip_from_model: camera.clip_from_model(width / height),
        eye: camera.eye.extend(meet),
        right: right.extend(half_height * width / height),
        up: up.extend(half_height),
        pixel: Vec4::new(2.0 / width, 2.0 / height, 0.0, 0.0),
    }
}
