//! The 3D images of a rig: the atlas of sampled fields and the operators' volumes.

use bytemuck::cast_slice;

use super::{Device, Method, Settings, machine::no_image, statics::Statics};
use crate::{
    Error, Result,
    field::{AtlasLayout, GridInput, atlas_layout},
    frame::FrameBuilder,
    gpu::{Class, Format, Gpu, Image3d},
    pass::field_grid,
    rig::Rig,
    twin::{self, Image},
};

/// Longest edge of an atlas where no device sets one.
const CPU_EDGE: u32 = 2048;

/// The images, where the deformer runs.
pub(super) enum Volumes {
    /// In host memory.
    Cpu {
        layout: AtlasLayout,
        atlas: Image,
        operators: Image,
    },
    /// In device memory.
    Gpu {
        layout: AtlasLayout,
        atlas: Image3d,
        operators: Image3d,
    },
}

/// Samples the fields and builds the operators that the method needs.
pub(super) fn prepare(
    device: &Device,
    rig: &Rig,
    statics: &Statics,
    settings: &Settings,
) -> Result<Volumes> {
    let has_fields = settings.method.has_fields();
    let fields = if has_fields { &rig.fields[..] } else { &[] };
    let operators = operators(rig, statics, settings)?;
    match device {
        Device::Cpu => {
            let layout = atlas_layout(fields.len(), CPU_EDGE)?;
            let grids =
                twin::field_grid::run(&GridInput::new(fields, layout), &field_grid::CONSTANTS);
            let texels = twin::field_grid::atlas(&grids, layout);
            let atlas = if fields.is_empty() {
                no_image()
            } else {
                Image {
                    extent: layout.extent(),
                    texels,
                }
            };
            Ok(Volumes::Cpu {
                layout,
                atlas,
                operators,
            })
        }
        Device::Gpu(gpu) => {
            let layout = atlas_layout(fields.len(), gpu.max_image_edge())?;
            let atlas = if fields.is_empty() {
                upload(gpu, "atlas", Class::Fields, &no_image())?
            } else {
                sample(gpu, &GridInput::new(fields, layout), layout)?
            };
            let operators = upload(gpu, "operators", Class::Operators, &operators)?;
            Ok(Volumes::Gpu {
                layout,
                atlas,
                operators,
            })
        }
    }
}

impl Volumes {
    /// The images in host memory.
    pub(super) fn into_images(self) -> Result<(AtlasLayout, Image, Image)> {
        match self {
            Self::Cpu {
                layout,
                atlas,
                operators,
            } => Ok((layout, atlas, operators)),
            Self::Gpu { .. } => Err(Error::argument(
                "device",
                "the images lie on another device",
            )),
        }
    }
}

/// The volumes of all operators in use, above each other in z.
fn operators(rig: &Rig, statics: &Statics, settings: &Settings) -> Result<Image> {
    if statics.operators.is_empty() {
        return Ok(no_image());
    }
    let mut texels = Vec::new();
    for &operator in &statics.operators {
        let volume = match settings.method {
            Method::Tracking => rig.tracking_volume(operator)?,
            _ => rig.volume(operator),
        };
        texels.extend(volume.texels);
    }
    let edge = crate::compose::EDGE as u32;
    Ok(Image {
        extent: [edge, edge, edge * statics.operators.len() as u32],
        texels,
    })
}

fn upload(gpu: &Gpu, name: &str, class: Class, image: &Image) -> Result<Image3d> {
    let on_device = gpu.image3d(name, class, image.extent, Format::Rgba16F)?;
    gpu.upload_image(&on_device, cast_slice(&image.texels))?;
    Ok(on_device)
}

/// Samples all fields on the GPU, in one dispatch.
fn sample(gpu: &Gpu, input: &GridInput, layout: AtlasLayout) -> Result<Image3d> {
    let atlas = gpu.image3d("atlas", Class::Fields, layout.extent(), Format::Rgba16F)?;
    let buffer = |name, bytes: &[u8]| gpu.buffer_with(name, Class::Transient, bytes);
    let fields = buffer("grid_fields", cast_slice(&input.fields))?;
    let centers = buffer("grid_centers", cast_slice(&input.centers))?;
    let segments = buffer("grid_segments", cast_slice(&input.segments))?;
    let mut builder = FrameBuilder::new(gpu, "field_grid");
    builder
        .pass(&field_grid::DECLARATION)
        .bind("fields", &fields)
        .bind("centers", &centers)
        .bind("segments", &segments)
        .bind_image("atlas", &atlas)
        .constants(&field_grid::CONSTANTS)
        .groups(field_grid::groups(input.fields.len()));
    builder.build()?.run()?;
    Ok(atlas)
}
