//! Graphics pipelines without vertex input: shaders pull what they need from storage buffers.

use std::io::Cursor;

use ash::vk;

use super::SAMPLES;
use crate::{
    Error, Result,
    gpu::{
        Buffer, Gpu, Subject,
        spirv::{self, Kind, Reflected, Stage},
    },
};

/// A pair of shaders as their user sees it.
pub(crate) struct Shaders {
    pub(crate) name: &'static str,
    /// SPIR-V of the vertex shader.
    pub(crate) vertex: &'static [u8],
    /// SPIR-V of the fragment shader.
    pub(crate) fragment: &'static [u8],
    /// Storage buffers of descriptor set 0 that the vertex shader reads, at the bindings from 0.
    pub(crate) buffers: u32,
    /// Bytes of push constants, seen by both.
    pub(crate) constants: u32,
    /// Test and write depth.
    pub(crate) depth: bool,
    /// Blend over what is there by the colour's alpha.
    pub(crate) blend: bool,
    /// Run the fragment shader for each sample of a pixel where the device can, for outlines that it finds itself.
    pub(crate) each_sample: bool,
}

/// Stages that see push constants.
pub(super) const STAGES: vk::ShaderStageFlags = vk::ShaderStageFlags::from_raw(
    vk::ShaderStageFlags::VERTEX.as_raw() | vk::ShaderStageFlags::FRAGMENT.as_raw(),
);

/// A pipeline with its one descriptor set; destroyed on drop.
pub(crate) struct Pipeline {
    gpu: Gpu,
    name: &'static str,
    buffers: u32,
    constants: u32,
    set_layout: vk::DescriptorSetLayout,
    pool: vk::DescriptorPool,
    set: vk::DescriptorSet,
    pub(super) layout: vk::PipelineLayout,
    pub(super) raw: vk::Pipeline,
}

impl Pipeline {
    pub(super) fn new(
        gpu: &Gpu,
        pass: vk::RenderPass,
        extent: vk::Extent2D,
        shaders: &Shaders,
    ) -> Result<Self> {
        let mut made = Self {
            gpu: gpu.clone(),
            name: shaders.name,
            buffers: shaders.buffers,
            constants: shaders.constants,
            set_layout: vk::DescriptorSetLayout::null(),
            pool: vk::DescriptorPool::null(),
            set: vk::DescriptorSet::null(),
            layout: vk::PipelineLayout::null(),
            raw: vk::Pipeline::null(),
        };
        check(shaders).map_err(|reason| Error::Pass {
            pass: shaders.name,
            reason,
        })?;
        made.create_layout(shaders)?;
        if shaders.buffers > 0 {
            made.create_set(shaders)?;
        }
        made.create_pipeline(pass, extent, shaders)?;
        Ok(made)
    }

    fn create_layout(&mut self, shaders: &Shaders) -> Result<()> {
        let bindings: Vec<_> = (0..shaders.buffers)
            .map(|binding| {
                vk::DescriptorSetLayoutBinding::default()
                    .binding(binding)
                    .descriptor_type(vk::DescriptorType::STORAGE_BUFFER)
                    .descriptor_count(1)
                    .stage_flags(vk::ShaderStageFlags::VERTEX)
            })
            .collect();
        let info = vk::DescriptorSetLayoutCreateInfo::default().bindings(&bindings);
        let device = self.gpu.device();
        // SAFETY: the device is alive, the bindings live until the call returns.
        self.set_layout = unsafe { device.create_descriptor_set_layout(&info, None) }
            .subject("vkCreateDescriptorSetLayout", self.name)?;
        let range = vk::PushConstantRange::default()
            .stage_flags(STAGES)
            .size(shaders.constants);
        let info = vk::PipelineLayoutCreateInfo::default()
            .set_layouts(std::slice::from_ref(&self.set_layout))
            .push_constant_ranges(std::slice::from_ref(&range));
        // SAFETY: the set layout is alive; 128 bytes of push constants are the most that is asked for and the least
        // that every device grants.
        self.layout = unsafe { device.create_pipeline_layout(&info, None) }
            .subject("vkCreatePipelineLayout", self.name)?;
        Ok(())
    }

    fn create_set(&mut self, shaders: &Shaders) -> Result<()> {
        let size = vk::DescriptorPoolSize::default()
            .ty(vk::DescriptorType::STORAGE_BUFFER)
            .descriptor_count(shaders.buffers);
        let info = vk::DescriptorPoolCreateInfo::default()
            .max_sets(1)
            .pool_sizes(std::slice::from_ref(&size));
        let device = self.gpu.device();
        // SAFETY: the device is alive.
        self.pool = unsafe { device.create_descriptor_pool(&info, None) }
            .subject("vkCreateDescriptorPool", self.name)?;
        let info = vk::DescriptorSetAllocateInfo::default()
            .descriptor_pool(self.pool)
            .set_layouts(std::slice::from_ref(&self.set_layout));
        // SAFETY: the pool has room for exactly this set and no other thread has it.
        let sets = unsafe { device.allocate_descriptor_sets(&info) }
            .subject("vkAllocateDescriptorSets", self.name)?;
        self.set = sets.first().copied().unwrap_or_default();
        Ok(())
    }

    fn create_pipeline(
        &mut self,
        pass: vk::RenderPass,
        extent: vk::Extent2D,
        shaders: &Shaders,
    ) -> Result<()> {
        let vertex = Module::new(&self.gpu, self.name, shaders.vertex)?;
        let fragment = Module::new(&self.gpu, self.name, shaders.fragment)?;
        let stages = [
            vertex.stage(vk::ShaderStageFlags::VERTEX),
            fragment.stage(vk::ShaderStageFlags::FRAGMENT),
        ];
        let vertex_input = vk::PipelineVertexInputStateCreateInfo::default();
        let assembly = vk::PipelineInputAssemblyStateCreateInfo::default()
            .topology(vk::PrimitiveTopology::TRIANGLE_LIST);
        let area = vk::Rect2D::default().extent(extent);
        let view = vk::Viewport {
            width: extent.width as f32,
            height: extent.height as f32,
            max_depth: 1.0,
            ..Default::default()
        };
        let viewport = vk::PipelineViewportStateCreateInfo::default()
            .viewports(std::slice::from_ref(&view))
            .scissors(std::slice::from_ref(&area));
        // Both sides are drawn: which one is seen is the fragment shader's business.
        let raster = vk::PipelineRasterizationStateCreateInfo::default()
            .cull_mode(vk::CullModeFlags::NONE)
            .front_face(vk::FrontFace::COUNTER_CLOCKWISE)
            .line_width(1.0);
        let each_sample = shaders.each_sample && self.gpu.features().sample_shading;
        let samples = vk::PipelineMultisampleStateCreateInfo::default()
            .rasterization_samples(SAMPLES)
            .sample_shading_enable(each_sample)
            .min_sample_shading(1.0);
        let depth = vk::PipelineDepthStencilStateCreateInfo::default()
            .depth_test_enable(shaders.depth)
            .depth_write_enable(shaders.depth)
            .depth_compare_op(vk::CompareOp::LESS);
        let over = vk::PipelineColorBlendAttachmentState::default()
            .blend_enable(shaders.blend)
            .src_color_blend_factor(vk::BlendFactor::SRC_ALPHA)
            .dst_color_blend_factor(vk::BlendFactor::ONE_MINUS_SRC_ALPHA)
            .src_alpha_blend_factor(vk::BlendFactor::ONE)
            .dst_alpha_blend_factor(vk::BlendFactor::ONE_MINUS_SRC_ALPHA)
            .color_write_mask(vk::ColorComponentFlags::RGBA);
        let blend = vk::PipelineColorBlendStateCreateInfo::default()
            .attachments(std::slice::from_ref(&over));
        let info = vk::GraphicsPipelineCreateInfo::default()
            .stages(&stages)
            .vertex_input_state(&vertex_input)
            .input_assembly_state(&assembly)
            .viewport_state(&viewport)
            .rasterization_state(&raster)
            .multisample_state(&samples)
            .depth_stencil_state(&depth)
            .color_blend_state(&blend)
            .layout(self.layout)
            .render_pass(pass);
        let device = self.gpu.device();
        // SAFETY: every struct that `info` points to lives until the call returns; modules, layout and pass are alive.
        let made =
            unsafe { device.create_graphics_pipelines(vk::PipelineCache::null(), &[info], None) };
        let made = made.map_err(|(_, code)| code);
        let made = made.subject("vkCreateGraphicsPipelines", self.name)?;
        self.raw = made.first().copied().unwrap_or_default();
        self.gpu.name(self.raw, self.name);
        Ok(())
    }

    /// Points the descriptor set at `buffers`, which nothing in flight may use. Fails where their number or the length
    /// of `constants` is not what the shaders declare.
    pub(super) fn bind(&self, buffers: &[&Buffer], constants: &[u8]) -> Result<()> {
        let given = (buffers.len() as u32, constants.len() as u32);
        if given != (self.buffers, self.constants) {
            return Err(Error::Pass {
                pass: self.name,
                reason: format!(
                    "{} buffers and {} bytes of constants given, {} and {} declared",
                    given.0, given.1, self.buffers, self.constants
                ),
            });
        }
        let infos: Vec<_> = buffers
            .iter()
            .map(|b| {
                vk::DescriptorBufferInfo::default()
                    .buffer(b.raw())
                    .range(vk::WHOLE_SIZE)
            })
            .collect();
        let writes: Vec<_> = infos
            .iter()
            .enumerate()
            .map(|(binding, info)| {
                vk::WriteDescriptorSet::default()
                    .dst_set(self.set)
                    .dst_binding(binding as u32)
                    .descriptor_type(vk::DescriptorType::STORAGE_BUFFER)
                    .buffer_info(std::slice::from_ref(info))
            })
            .collect();
        // SAFETY: set and buffers are alive, and every submission with this set was waited for.
        unsafe { self.gpu.device().update_descriptor_sets(&writes, &[]) };
        Ok(())
    }

    /// The descriptor set, where the shaders have one.
    pub(super) fn set(&self) -> Option<vk::DescriptorSet> {
        (self.set != vk::DescriptorSet::null()).then_some(self.set)
    }
}

impl Drop for Pipeline {
    fn drop(&mut self) {
        let (raw, layout, pool, set_layout) = (self.raw, self.layout, self.pool, self.set_layout);
        // SAFETY: nobody else has these handles and the device is done with them when it calls this; null handles, which a
        // failed creation leaves, are ignored.
        self.gpu.bury(move |device| unsafe {
            device.destroy_pipeline(raw, None);
            device.destroy_pipeline_layout(layout, None);
            device.destroy_descriptor_pool(pool, None);
            device.destroy_descriptor_set_layout(set_layout, None);
        });
    }
}

/// Compares the declaration with what the shaders themselves say.
fn check(shaders: &Shaders) -> Result<(), String> {
    for (stage, bytes) in [
        (Stage::Vertex, shaders.vertex),
        (Stage::Fragment, shaders.fragment),
    ] {
        let found = spirv::reflect_graphics(&spirv::words(bytes)?, stage)?;
        let buffers = match stage {
            Stage::Vertex => shaders.buffers,
            Stage::Fragment => 0,
        };
        let read = |b: &Reflected| b.set == 0 && b.kind == Kind::Storage && b.readonly;
        let numbers = found.bindings.iter().map(|b| b.binding);
        if !numbers.eq(0..buffers) || !found.bindings.iter().all(read) {
            let bindings = &found.bindings;
            return Err(format!(
                "{stage:?}: {buffers} buffers to read are declared, the shader has {bindings:?}"
            ));
        }
        // The backdrop's vertex shader has no use for constants.
        if found.constants != 0 && found.constants != shaders.constants {
            return Err(format!(
                "{stage:?}: {} bytes of push constants are declared, the shader has {}",
                shaders.constants, found.constants
            ));
        }
    }
    Ok(())
}

/// A shader module; destroyed on drop.
struct Module {
    gpu: Gpu,
    raw: vk::ShaderModule,
}

impl Module {
    fn new(gpu: &Gpu, name: &'static str, spirv: &[u8]) -> Result<Self> {
        let words = ash::util::read_spv(&mut Cursor::new(spirv)).map_err(|e| Error::Pass {
            pass: name,
            reason: format!("not SPIR-V: {e}"),
        })?;
        let info = vk::ShaderModuleCreateInfo::default().code(&words);
        // SAFETY: the words are SPIR-V compiled with the crate and live until the call returns.
        let raw = unsafe { gpu.device().create_shader_module(&info, None) }
            .subject("vkCreateShaderModule", name)?;
        let gpu = gpu.clone();
        Ok(Self { gpu, raw })
    }

    fn stage(&self, stage: vk::ShaderStageFlags) -> vk::PipelineShaderStageCreateInfo<'static> {
        vk::PipelineShaderStageCreateInfo::default()
            .stage(stage)
            .module(self.raw)
            .name(c"main")
    }
}

impl Drop for Module {
    fn drop(&mut self) {
        // SAFETY: a module is not needed once its pipeline is made.
        unsafe { self.gpu.device().destroy_shader_module(self.raw, None) };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SKIN: Shaders = Shaders {
        name: "skin",
        vertex: include_bytes!("../../../shaders/spirv/skin.vert.spv"),
        fragment: include_bytes!("../../../shaders/spirv/skin.frag.spv"),
        buffers: 4,
        constants: 128,
        depth: true,
        blend: false,
        each_sample: false,
    };

    #[test]
    fn a_declaration_that_its_shaders_contradict_is_refused() {
        assert_eq!(check(&SKIN), Ok(()));
        let refused = |shaders: &Shaders, part: &str| {
            let reason = check(shaders);
            let found = matches!(&reason, Err(text) if text.contains(part));
            assert!(found, "{reason:?} lacks {part:?}");
        };
        refused(&Shaders { buffers: 3, ..SKIN }, "3 buffers to read");
        refused(
            &Shaders {
                constants: 64,
                ..SKIN
            },
            "64 bytes of push constants",
        );
        let vertex = SKIN.fragment;
        refused(&Shaders { vertex, ..SKIN }, "another stage");
        let cut = &SKIN.vertex[..SKIN.vertex.len() - 2];
        refused(
            &Shaders {
                vertex: cut,
                ..SKIN
            },
            "not made of words",
        );
    }
}
