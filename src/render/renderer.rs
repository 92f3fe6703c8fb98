//! Draws a deformed character offscreen.

use bytemuck::{Pod, Zeroable};
use glam::{Mat4, Vec3, Vec4};

use super::{Camera, Picture, Spheres, sphere_pass::SpherePass};
use crate::{
    Error, Result,
    gpu::{
        Buffer, Class, Gpu,
        raster::{Canvas, Draw, Pipeline, Shaders},
    },
};

const SKIN: Shaders = Shaders {
    name: "skin",
    vertex: include_bytes!("../../shaders/spirv/skin.vert.spv"),
    fragment: include_bytes!("../../shaders/spirv/skin.frag.spv"),
    buffers: 4,
    constants: size_of::<SkinConstants>() as u32,
    depth: true,
    blend: false,
    each_sample: false,
};

const BACKDROP: Shaders = Shaders {
    name: "backdrop",
    vertex: include_bytes!("../../shaders/spirv/backdrop.vert.spv"),
    fragment: include_bytes!("../../shaders/spirv/backdrop.frag.spv"),
    buffers: 0,
    constants: size_of::<[Vec4; 2]>() as u32,
    depth: false,
    blend: false,
    each_sample: false,
};

/// Names of the vertex shader's storage buffers, in the order of its bindings.
const BUFFERS: [&str; 4] = [
    "render.positions",
    "render.normals",
    "render.colours",
    "render.corners",
];

/// Width of a wireframe's edges, pixels.
const EDGE_WIDTH: f32 = 1.0;
/// Linear colour and opacity of a wireframe's edges.
const EDGE: Vec4 = Vec4::new(0.02, 0.02, 0.03, 0.45);

/// Push constants of `skin.vert` and `skin.frag`.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct SkinConstants {
    clip_from_model: Mat4,
    eye: Vec4,
    right: Vec4,
    up: Vec4,
    edge: Vec4,
}

/// What is behind the character: a vertical gradient, sRGB.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Background {
    /// Colour of the first row.
    pub top: [u8; 3],
    /// Colour of the last row.
    pub bottom: [u8; 3],
}

impl Default for Background {
    /// Studio grey, lighter above.
    fn default() -> Self {
        Self {
            top: [240, 241, 243],
            bottom: [206, 209, 214],
        }
    }
}

/// What to draw; all columns have a row a vertex of the file, in model space.
#[derive(Clone, Copy, Debug)]
pub struct Scene<'a> {
    /// Positions.
    pub positions: &'a [Vec3],
    /// Unit normals; a zero normal is replaced by its triangle's.
    pub normals: &'a [Vec3],
    /// Linear RGB of the front side, as from [`colours`](super::colours).
    pub colours: &'a [Vec3],
    /// Triangles as vertex rows, counter-clockwise when seen from the front.
    pub triangles: &'a [[u32; 3]],
    /// Where from.
    pub camera: Camera,
    /// Draw the triangles' edges too.
    pub wireframe: bool,
    /// What is behind.
    pub background: Background,
}

/// Draws scenes into pictures of one size, one after the other, and keeps its buffers between them.
pub struct Renderer {
    gpu: Gpu,
    canvas: Canvas,
    skin: Pipeline,
    backdrop: Pipeline,
    buffers: [Option<Buffer>; 4],
    /// Made with the first picture that has spheres.
    spheres: Option<SpherePass>,
}

impl Renderer {
    /// A renderer of pictures of `width` × `height` pixels.
    ///
    /// Fails where the device cannot draw pictures of this size, or is out of memory or budget.
    pub fn new(gpu: &Gpu, width: u32, height: u32) -> Result<Self> {
        let canvas = Canvas::new(gpu, width, height)?;
        Ok(Self {
            skin: canvas.pipeline(&SKIN)?,
            backdrop: canvas.pipeline(&BACKDROP)?,
            gpu: gpu.clone(),
            canvas,
            buffers: [const { None }; 4],
            spheres: None,
        })
    }

    /// Width over height of the pictures, as cameras want it.
    pub fn aspect(&self) -> f32 {
        let (width, height) = self.canvas.size();
        width as f32 / height as f32
    }

    /// Draws `scene`, front sides in its colours and back sides in magenta, and waits for the picture.
    ///
    /// Fails where columns differ in length, a triangle names no vertex, or the device fails.
    pub fn draw(&mut self, scene: &Scene) -> Result<Picture> {
        self.draw_with(scene, &Spheres::default())
    }

    /// As [`Renderer::draw`], with `spheres` in the same picture: what is nearer hides what is farther, whichever it is.
    pub fn draw_with(&mut self, scene: &Scene, spheres: &Spheres) -> Result<Picture> {
        check(scene)?;
        if self.spheres.is_none() && !spheres.primitives.is_empty() {
            self.spheres = Some(SpherePass::new(&self.canvas)?);
        }
        let (gpu, size) = (&self.gpu, self.canvas.size());
        let pass = self.spheres.as_mut();
        let pass = pass.filter(|_| !spheres.primitives.is_empty());
        let round = pass.map(|p| p.bind(gpu, spheres, &scene.camera, size));
        let round = round.transpose()?;
        let background = [scene.background.top, scene.background.bottom].map(opaque);
        let constants = constants(scene, size.0 as f32 / size.1 as f32);
        let rows: [&[u8]; 4] = [
            bytemuck::cast_slice(scene.positions),
            bytemuck::cast_slice(scene.normals),
            bytemuck::cast_slice(scene.colours),
            bytemuck::cast_slice(scene.triangles),
        ];
        let mut bound = Vec::with_capacity(rows.len());
        for ((slot, name), bytes) in self.buffers.iter_mut().zip(BUFFERS).zip(rows) {
            bound.push(filled(gpu, slot, name, bytes)?);
        }
        let mut draws = vec![
            Draw {
                pipeline: &self.backdrop,
                buffers: &[],
                constants: bytemuck::bytes_of(&background),
                vertices: 3,
            },
            Draw {
                pipeline: &self.skin,
                buffers: &bound,
                constants: bytemuck::bytes_of(&constants),
                vertices: 3 * scene.triangles.len() as u32,
            },
        ];
        draws.extend(round.iter().map(|r| r.draw()));
        let rgba = self.canvas.draw(&draws)?;
        let (width, height) = size;
        Ok(Picture {
            width,
            height,
            rgba,
        })
    }
}

/// The buffer in `slot`, made anew only where it is too small, with `bytes` at its start.
pub(super) fn filled<'a>(
    gpu: &Gpu,
    slot: &'a mut Option<Buffer>,
    name: &str,
    bytes: &[u8],
) -> Result<&'a Buffer> {
    let needed = bytes.len().max(16) as u64;
    let buffer = match slot.take().filter(|b| b.bytes() >= needed) {
        Some(buffer) => buffer,
        None => gpu.buffer(name, Class::Transient, needed)?,
    };
    gpu.upload(&buffer, bytes)?;
    Ok(slot.insert(buffer))
}

fn check(scene: &Scene) -> Result<()> {
    let count = scene.positions.len();
    for (name, len) in [
        ("normals", scene.normals.len()),
        ("colours", scene.colours.len()),
    ] {
        if len != count {
            let reason = format!("{len} rows for {count} positions");
            return Err(Error::argument(name, reason));
        }
    }
    let outside = |t: &[u32; 3]| t.iter().any(|&row| row as usize >= count);
    match scene.triangles.iter().position(outside) {
        Some(i) => Err(Error::argument(
            format!("triangle {i}"),
            format!("{:?} of {count} vertices", scene.triangles[i]),
        )),
        None => Ok(()),
    }
}

fn opaque(rgb: [u8; 3]) -> Vec4 {
    (Vec3::from(rgb.map(f32::from)) / 255.0).extend(1.0)
}

fn constants(scene: &Scene, aspect: f32) -> SkinConstants {
    let [right, up, back] = scene.camera.axes();
    let eye = match scene.camera.projection {
        super::Projection::Perspective { .. } => scene.camera.eye.extend(1.0),
        super::Projection::Orthographic { .. } => back.extend(0.0),
    };
    SkinConstants {
        clip_from_model: scene.camera.clip_from_model(aspect),
        eye,
        right: right.extend(if scene.wireframe { EDGE_WIDTH } else { 0.0 }),
        up: up.extend(0.0),
        edge: EDGE,
    }
}
