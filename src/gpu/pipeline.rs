//! Compute pipelines: made once a device and declaration, after the shader agreed with the declaration.

use std::{ffi::CString, sync::Arc};

use ash::vk;

use super::{
    declare::{Access, Declaration},
    fault::{Subject, lock},
    image::Format,
    shared::{PUSH_CONSTANTS, Shared},
    spirv::{self, Kind, Reflected, Reflection},
};
use crate::{Error, Result};

/// A compute pipeline; destroyed with the device.
pub(crate) struct Pipeline {
    pub(crate) raw: vk::Pipeline,
    pub(crate) layout: vk::PipelineLayout,
    pub(crate) set_layout: vk::DescriptorSetLayout,
    pub(crate) declaration: Declaration,
    /// Format of each storage image by binding.
    pub(crate) formats: Vec<Option<Format>>,
}

/// What binding a pipeline takes: a copy that is at hand where commands are recorded.
#[derive(Clone, Copy)]
pub(crate) struct Bound {
    pub(super) pipeline: vk::Pipeline,
    pub(super) layout: vk::PipelineLayout,
}

impl Pipeline {
    /// For binding it, as long as it lives.
    pub(crate) fn bound(&self) -> Bound {
        Bound {
            pipeline: self.raw,
            layout: self.layout,
        }
    }

    /// Destroys it; the device has to be idle and nobody may use the pipeline after it.
    pub(crate) fn destroy(&self, device: &ash::Device) {
        // SAFETY: see above; called once, at the device's end.
        unsafe {
            device.destroy_pipeline(self.raw, None);
            device.destroy_pipeline_layout(self.layout, None);
            device.destroy_descriptor_set_layout(self.set_layout, None);
        }
    }
}

impl Access {
    pub(crate) fn descriptor(self) -> vk::DescriptorType {
        match self {
            Self::Read | Self::Write | Self::ReadWrite => vk::DescriptorType::STORAGE_BUFFER,
            Self::Uniform => vk::DescriptorType::UNIFORM_BUFFER,
            Self::Texels | Self::Words => vk::DescriptorType::UNIFORM_TEXEL_BUFFER,
            Self::Sampled => vk::DescriptorType::COMBINED_IMAGE_SAMPLER,
            Self::ImageWrite => vk::DescriptorType::STORAGE_IMAGE,
        }
    }
}

impl Shared {
    /// The pipeline of a declaration and a value of specialization constant 0, made on first use.
    pub(crate) fn pipeline(
        &self,
        declaration: &Declaration,
        variant: u32,
    ) -> Result<Arc<Pipeline>> {
        let mut pipelines = lock(&self.pipelines);
        if let Some(known) = pipelines.get(&(declaration.name, variant)) {
            return match known.declaration.spirv == declaration.spirv {
                true => Ok(known.clone()),
                false => Err(refuse(declaration, "another shader has the same name")),
            };
        }
        let pipeline = Arc::new(self.create_pipeline(declaration, variant)?);
        pipelines.insert((declaration.name, variant), pipeline.clone());
        Ok(pipeline)
    }

    fn create_pipeline(&self, declaration: &Declaration, variant: u32) -> Result<Pipeline> {
        let refused = |reason: String| refuse(declaration, reason);
        let words = spirv::words(declaration.spirv).map_err(refused)?;
        let reflection = spirv::reflect(&words).map_err(refused)?;
        check(declaration, &reflection).map_err(refused)?;
        self.check_limits(declaration)?;
        let entry = CString::new(&*reflection.entry).map_err(|e| refused(e.to_string()))?;
        let (device, name) = (&self.device, declaration.name);
        let set_layout = set_layout(device, declaration)?;
        // SAFETY: what fails leaves nothing behind but the handles made before it, which nobody else has.
        let destroy_set = || unsafe { device.destroy_descriptor_set_layout(set_layout, None) };
        let layout = layout(device, declaration, set_layout).inspect_err(|_| destroy_set())?;
        let constants = [variant, u32::from(self.features.exact_filter)];
        let raw = compute(device, name, &words, &entry, layout, constants).inspect_err(|_| {
            // SAFETY: as above.
            unsafe { device.destroy_pipeline_layout(layout, None) };
            destroy_set();
        })?;
        self.name(raw, name);
        self.name(layout, name);
        self.name(set_layout, name);
        let format = |b: &Reflected| match b.kind {
            Kind::Image { format, .. } => format,
            _ => None,
        };
        Ok(Pipeline {
            raw,
            layout,
            set_layout,
            declaration: *declaration,
            formats: reflection.bindings.iter().map(format).collect(),
        })
    }

    fn check_limits(&self, declaration: &Declaration) -> Result<()> {
        let limits = &self.physical.properties.limits;
        let (size, most) = (declaration.local_size, limits.max_compute_work_group_size);
        let invocations: u64 = size.iter().map(|s| u64::from(*s)).product();
        let fits = size.iter().zip(most).all(|(s, m)| *s <= m);
        if !fits || invocations > u64::from(limits.max_compute_work_group_invocations) {
            let most = format!(
                "{most:?} or {} in all",
                limits.max_compute_work_group_invocations
            );
            return Err(refuse(
                declaration,
                format!("workgroups of {size:?} pass this device's {most}"),
            ));
        }
        Ok(())
    }
}

fn refuse(declaration: &Declaration, reason: impl Into<String>) -> Error {
    Error::Pass {
        pass: declaration.name,
        reason: reason.into(),
    }
}

/// Compares what a pass declares with what its shader says.
pub(crate) fn check(declaration: &Declaration, shader: &Reflection) -> Result<(), String> {
    if declaration.local_size != shader.local_size {
        let (says, is) = (declaration.local_size, shader.local_size);
        return Err(format!(
            "local size {says:?} is declared, the shader has {is:?}"
        ));
    }
    check_constants(declaration.constants, shader.constants)?;
    for (row, binding) in declaration.bindings.iter().enumerate() {
        let name = binding.name;
        let found = shader
            .bindings
            .iter()
            .find(|b| (b.set, b.binding) == (0, row as u32));
        let found = found
            .ok_or_else(|| format!("binding {row} ({name}) is declared, the shader lacks it"))?;
        if !agrees(binding.access, found) {
            let (access, is) = (binding.access, describe(found));
            return Err(format!(
                "binding {row} ({name}) is declared {access:?}, the shader has {is}"
            ));
        }
    }
    // Every declared binding was found, so that any more in the shader are undeclared or doubled.
    match shader
        .bindings
        .iter()
        .find(|b| b.set != 0 || b.binding as usize >= declaration.bindings.len())
    {
        Some(b) => Err(format!(
            "the shader's set {} binding {} is not declared",
            b.set, b.binding
        )),
        None if shader.bindings.len() > declaration.bindings.len() => {
            Err("the shader uses a binding number twice".into())
        }
        None => Ok(()),
    }
}

/// Rust may pad a struct's end up to its alignment, 16 at most; SPIR-V does not.
fn check_constants(declared: u32, shader: u32) -> Result<(), String> {
    if declared < shader || declared > shader.next_multiple_of(16) {
        return Err(format!(
            "{declared} bytes of push constants are declared, the shader has {shader}"
        ));
    }
    if declared > PUSH_CONSTANTS || !declared.is_multiple_of(4) {
        return Err(format!(
            "{declared} bytes of push constants: {PUSH_CONSTANTS} at most, in words of 4"
        ));
    }
    Ok(())
}

fn agrees(access: Access, found: &Reflected) -> bool {
    let qualifiers = (found.readonly, found.writeonly);
    match (access, found.kind) {
        (Access::Read, Kind::Storage) => qualifiers == (true, false),
        (Access::Write, Kind::Storage) => qualifiers == (false, true),
        (Access::ReadWrite, Kind::Storage) => qualifiers == (false, false),
        (Access::Uniform, Kind::Uniform)
        | (Access::Texels, Kind::Texels)
        | (Access::Words, Kind::Words) => true,
        (Access::Sampled, Kind::Sampled { volume }) => volume,
        (Access::ImageWrite, Kind::Image { volume, format }) => {
            volume && format.is_some() && qualifiers == (false, true)
        }
        _ => false,
    }
}

fn describe(found: &Reflected) -> String {
    let qualifier = match (found.readonly, found.writeonly) {
        (true, true) => "readonly writeonly ",
        (true, false) => "readonly ",
        (false, true) => "writeonly ",
        (false, false) => "",
    };
    format!("{qualifier}{:?}", found.kind)
}

fn set_layout(device: &ash::Device, declaration: &Declaration) -> Result<vk::DescriptorSetLayout> {
    let binding = |(row, binding): (usize, &super::Binding)| {
        vk::DescriptorSetLayoutBinding::default()
            .binding(row as u32)
            .descriptor_type(binding.access.descriptor())
            .descriptor_count(1)
            .stage_flags(vk::ShaderStageFlags::COMPUTE)
    };
    let bindings: Vec<_> = declaration
        .bindings
        .iter()
        .enumerate()
        .map(binding)
        .collect();
    let info = vk::DescriptorSetLayoutCreateInfo::default().bindings(&bindings);
    // SAFETY: the device is alive, the bindings live until the call returns.
    unsafe { device.create_descriptor_set_layout(&info, None) }
        .subject("vkCreateDescriptorSetLayout", declaration.name)
}

fn layout(
    device: &ash::Device,
    declaration: &Declaration,
    set_layout: vk::DescriptorSetLayout,
) -> Result<vk::PipelineLayout> {
    let sets = [set_layout];
    let range = [vk::PushConstantRange {
        stage_flags: vk::ShaderStageFlags::COMPUTE,
        offset: 0,
        size: declaration.constants,
    }];
    let ranges = if declaration.constants > 0 {
        &range[..]
    } else {
        &[]
    };
    let info = vk::PipelineLayoutCreateInfo::default()
        .set_layouts(&sets)
        .push_constant_ranges(ranges);
    // SAFETY: device and set layout are alive; the range was checked.
    unsafe { device.create_pipeline_layout(&info, None) }
        .subject("vkCreatePipelineLayout", declaration.name)
}

fn compute(
    device: &ash::Device,
    name: &str,
    words: &[u32],
    entry: &std::ffi::CStr,
    layout: vk::PipelineLayout,
    constants: [u32; 2],
) -> Result<vk::Pipeline> {
    let info = vk::ShaderModuleCreateInfo::default().code(words);
    // SAFETY: the device is alive; the words come from the SPIR-V compiler and were embedded at build time.
    let module = unsafe { device.create_shader_module(&info, None) }
        .subject("vkCreateShaderModule", name)?;
    // Specialization constants 0 and 1; a shader ignores those that it has not.
    let entries = [0, 1].map(|id| vk::SpecializationMapEntry {
        constant_id: id,
        offset: 4 * id,
        size: 4,
    });
    let special = vk::SpecializationInfo::default()
        .map_entries(&entries)
        .data(bytemuck::bytes_of(&constants));
    let stage = vk::PipelineShaderStageCreateInfo::default()
        .specialization_info(&special)
        .stage(vk::ShaderStageFlags::COMPUTE)
        .module(module)
        .name(entry);
    let info = vk::ComputePipelineCreateInfo::default()
        .stage(stage)
        .layout(layout);
    // SAFETY: module and layout are alive and fit, which `check` has found; the module is not needed afterwards.
    let made = unsafe {
        let made = device.create_compute_pipelines(vk::PipelineCache::null(), &[info], None);
        device.destroy_shader_module(module, None);
        made
    };
    let made = made
        .map_err(|(_, code)| code)
        .subject("vkCreateComputePipelines", name)?;
    Ok(made[0])
}

#[cfg(test)]
#[path = "pipeline_tests.rs"]
#[allow(clippy::unwrap_used)]
mod tests;
