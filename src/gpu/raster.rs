//! Rasterisation into offscreen pictures: four samples a pixel, a depth buffer, vertices pulled from storage buffers.
//!
//! Four samples of an 8-bit colour and of a depth attachment are among the limits that Vulkan requires of every device
//! with a graphics queue, so there is no other path.

mod pipeline;

use ash::vk;

pub(crate) use pipeline::{Pipeline, Shaders};

use self::pipeline::STAGES;
use super::{Buffer, Class, Gpu, Image, Recorder, Subject};
use crate::{Error, Result};

const COLOUR: vk::Format = vk::Format::R8G8B8A8_UNORM;
const DEPTH: vk::Format = vk::Format::D32_SFLOAT;
const SAMPLES: vk::SampleCountFlags = vk::SampleCountFlags::TYPE_4;

/// One draw call: `vertices` corners, three a triangle.
pub(crate) struct Draw<'a> {
    pub(crate) pipeline: &'a Pipeline,
    /// Storage buffers, in the order of their bindings.
    pub(crate) buffers: &'a [&'a Buffer],
    pub(crate) constants: &'a [u8],
    pub(crate) vertices: u32,
}

/// A picture to draw into and read back.
pub(crate) struct Canvas {
    gpu: Gpu,
    extent: vk::Extent2D,
    pass: vk::RenderPass,
    framebuffer: vk::Framebuffer,
    /// Multisampled colour, depth, and the colour that the former is resolved into; the order of the pass.
    attachments: [Image; 3],
    pixels: Buffer,
}

impl Canvas {
    /// A target of `width` × `height` pixels.
    pub(crate) fn new(gpu: &Gpu, width: u32, height: u32) -> Result<Self> {
        check(gpu, width, height)?;
        let mut made = Self {
            gpu: gpu.clone(),
            extent: vk::Extent2D { width, height },
            pass: vk::RenderPass::null(),
            framebuffer: vk::Framebuffer::null(),
            attachments: attachments(gpu, [width, height])?,
            pixels: gpu.buffer(
                "render.pixels",
                Class::Readback,
                4 * u64::from(width) * u64::from(height),
            )?,
        };
        made.pass = create_pass(gpu)?;
        made.create_framebuffer()?;
        Ok(made)
    }

    /// Width and height in pixels.
    pub(crate) fn size(&self) -> (u32, u32) {
        (self.extent.width, self.extent.height)
    }

    /// A pipeline that draws into targets of this one's size.
    pub(crate) fn pipeline(&self, shaders: &Shaders) -> Result<Pipeline> {
        Pipeline::new(&self.gpu, self.pass, self.extent, shaders)
    }

    /// Draws in the order given and returns four bytes a pixel, rows from the top.
    pub(crate) fn draw(&mut self, draws: &[Draw<'_>]) -> Result<Vec<u8>> {
        for draw in draws {
            draw.pipeline.bind(draw.buffers, draw.constants)?;
        }
        self.gpu.immediate("render", |recorder| {
            self.begin(recorder);
            draws.iter().for_each(|draw| self.record(recorder, draw));
            self.end(recorder);
            Ok(())
        })?;
        self.gpu.download(&self.pixels)
    }

    fn create_framebuffer(&mut self) -> Result<()> {
        let views: Vec<_> = self.attachments.iter().map(|a| a.view).collect();
        let info = vk::FramebufferCreateInfo::default()
            .render_pass(self.pass)
            .attachments(&views)
            .width(self.extent.width)
            .height(self.extent.height)
            .layers(1);
        // SAFETY: pass and views are alive, the views have the pass's formats and the framebuffer's extent.
        self.framebuffer = unsafe { self.gpu.device().create_framebuffer(&info, None) }
            .subject("vkCreateFramebuffer", "render")?;
        Ok(())
    }

    fn begin(&self, recorder: &Recorder<'_>) {
        let colour = vk::ClearValue::default();
        let depth = vk::ClearValue {
            depth_stencil: vk::ClearDepthStencilValue {
                depth: 1.0,
                stencil: 0,
            },
        };
        let info = vk::RenderPassBeginInfo::default()
            .render_pass(self.pass)
            .framebuffer(self.framebuffer)
            .render_area(vk::Rect2D::default().extent(self.extent));
        let clear = [colour, depth];
        let info = info.clear_values(&clear);
        let device = self.gpu.device();
        // SAFETY: recording; pass and framebuffer are alive and fit each other. What was uploaded is visible: an
        // immediate submission starts with a barrier against everything before it.
        unsafe { device.cmd_begin_render_pass(recorder.raw, &info, vk::SubpassContents::INLINE) };
    }

    fn record(&self, recorder: &Recorder<'_>, draw: &Draw<'_>) {
        let (device, pipeline, commands) = (self.gpu.device(), draw.pipeline, recorder.raw);
        let point = vk::PipelineBindPoint::GRAPHICS;
        // SAFETY: recording inside the pass; pipeline and set are alive and of this pass; `bind` has checked the
        // constants' length and the buffers' number.
        unsafe {
            device.cmd_bind_pipeline(commands, point, pipeline.raw);
            if let Some(set) = pipeline.set() {
                let layout = pipeline.layout;
                device.cmd_bind_descriptor_sets(commands, point, layout, 0, &[set], &[]);
            }
            device.cmd_push_constants(commands, pipeline.layout, STAGES, 0, draw.constants);
            device.cmd_draw(commands, draw.vertices, 1, 0, 0);
        }
    }

    /// Ends the pass, which resolves the samples and leaves the picture ready to be copied, and copies it.
    fn end(&self, recorder: &Recorder<'_>) {
        let layers = vk::ImageSubresourceLayers::default()
            .aspect_mask(vk::ImageAspectFlags::COLOR)
            .layer_count(1);
        let region = vk::BufferImageCopy::default()
            .image_subresource(layers)
            .image_extent(self.extent.into());
        // SAFETY: recording inside the pass.
        unsafe { self.gpu.device().cmd_end_render_pass(recorder.raw) };
        let layout = vk::ImageLayout::TRANSFER_SRC_OPTIMAL;
        recorder.copy_from_image(self.attachments[2].raw, layout, &self.pixels, region);
    }
}

impl Drop for Canvas {
    fn drop(&mut self) {
        let (framebuffer, pass) = (self.framebuffer, self.pass);
        // SAFETY: nobody else has these handles and the device is done with them when it calls this; null handles, which a
        // failed creation leaves, are ignored.
        self.gpu.bury(move |device| unsafe {
            device.destroy_framebuffer(framebuffer, None);
            device.destroy_render_pass(pass, None);
        });
    }
}

/// Multisampled colour, multisampled depth, and the colour that samples are resolved into.
fn attachments(gpu: &Gpu, size: [u32; 2]) -> Result<[Image; 3]> {
    use vk::{ImageAspectFlags as Aspect, ImageUsageFlags as Usage};
    let (colour, once) = (Usage::COLOR_ATTACHMENT, Usage::TRANSIENT_ATTACHMENT);
    let depth = Usage::DEPTH_STENCIL_ATTACHMENT;
    let one = vk::SampleCountFlags::TYPE_1;
    let image = |name, format, usage, aspect, samples| {
        gpu.target(name, size, format, usage, aspect, samples)
    };
    Ok([
        image(
            "render.samples",
            COLOUR,
            colour | once,
            Aspect::COLOR,
            SAMPLES,
        )?,
        image("render.depth", DEPTH, depth | once, Aspect::DEPTH, SAMPLES)?,
        image(
            "render.resolved",
            COLOUR,
            colour | Usage::TRANSFER_SRC,
            Aspect::COLOR,
            one,
        )?,
    ])
}

fn check(gpu: &Gpu, width: u32, height: u32) -> Result<()> {
    let size = |reason| Error::argument("size", format!("{width}×{height} pixels: {reason}"));
    if !gpu.has_graphics() {
        let reason = "the device has no graphics queue and cannot draw";
        return Err(Error::argument("device", reason));
    }
    let limits = gpu.limits();
    let most = limits
        .max_framebuffer_width
        .min(limits.max_framebuffer_height)
        .min(limits.max_image_dimension2_d);
    match width.min(height) >= 1 && width.max(height) <= most {
        true => Ok(()),
        false => Err(size(format!(
            "each side must be 1 to {most} on this device"
        ))),
    }
}

/// Samples are cleared, drawn and thrown away; their resolution is kept, ready to be copied.
fn create_pass(gpu: &Gpu) -> Result<vk::RenderPass> {
    use vk::{AttachmentLoadOp as Load, AttachmentStoreOp as Store, ImageLayout as Layout};
    let attachment = |format, samples, load, store, last| {
        vk::AttachmentDescription::default()
            .format(format)
            .samples(samples)
            .load_op(load)
            .store_op(store)
            .stencil_load_op(Load::DONT_CARE)
            .stencil_store_op(Store::DONT_CARE)
            .final_layout(last)
    };
    let (colour_layout, depth_layout) = (
        Layout::COLOR_ATTACHMENT_OPTIMAL,
        Layout::DEPTH_STENCIL_ATTACHMENT_OPTIMAL,
    );
    let one = vk::SampleCountFlags::TYPE_1;
    let attachments = [
        attachment(
            COLOUR,
            SAMPLES,
            Load::CLEAR,
            Store::DONT_CARE,
            colour_layout,
        ),
        attachment(DEPTH, SAMPLES, Load::CLEAR, Store::DONT_CARE, depth_layout),
        attachment(
            COLOUR,
            one,
            Load::DONT_CARE,
            Store::STORE,
            Layout::TRANSFER_SRC_OPTIMAL,
        ),
    ];
    let reference = |attachment, layout| vk::AttachmentReference { attachment, layout };
    let (colour, depth, resolve) = (
        [reference(0, colour_layout)],
        reference(1, depth_layout),
        [reference(2, colour_layout)],
    );
    let subpass = vk::SubpassDescription::default()
        .pipeline_bind_point(vk::PipelineBindPoint::GRAPHICS)
        .color_attachments(&colour)
        .resolve_attachments(&resolve)
        .depth_stencil_attachment(&depth);
    let dependencies = dependencies();
    let info = vk::RenderPassCreateInfo::default()
        .attachments(&attachments)
        .subpasses(std::slice::from_ref(&subpass))
        .dependencies(&dependencies);
    // SAFETY: every struct that `info` points to lives until the call returns.
    unsafe { gpu.device().create_render_pass(&info, None) }.subject("vkCreateRenderPass", "render")
}

/// Before: the last picture's drawing and copying is done. After: the picture may be copied.
fn dependencies() -> [vk::SubpassDependency; 2] {
    use vk::{AccessFlags as Access, PipelineStageFlags as Stage};
    let drawing =
        Stage::COLOR_ATTACHMENT_OUTPUT | Stage::EARLY_FRAGMENT_TESTS | Stage::LATE_FRAGMENT_TESTS;
    let writes = Access::COLOR_ATTACHMENT_WRITE | Access::DEPTH_STENCIL_ATTACHMENT_WRITE;
    let reads = Access::COLOR_ATTACHMENT_READ | Access::DEPTH_STENCIL_ATTACHMENT_READ;
    [
        vk::SubpassDependency {
            src_subpass: vk::SUBPASS_EXTERNAL,
            dst_subpass: 0,
            src_stage_mask: drawing | Stage::TRANSFER,
            dst_stage_mask: drawing,
            src_access_mask: writes,
            dst_access_mask: reads | writes,
            ..Default::default()
        },
        vk::SubpassDependency {
            src_subpass: 0,
            dst_subpass: vk::SUBPASS_EXTERNAL,
            src_stage_mask: Stage::COLOR_ATTACHMENT_OUTPUT,
            dst_stage_mask: Stage::TRANSFER,
            src_access_mask: Access::COLOR_ATTACHMENT_WRITE,
            dst_access_mask: Access::TRANSFER_READ,
            ..Default::default()
        },
    ]
}
