//! Checks the steps of a frame and makes all that its submissions need.

use std::{ffi::CString, sync::Arc};

use ash::vk;

use super::{
    Frame, FrameBuilder, SlotState,
    builder::{Copy, Extent, Fill, Pass, Resource, Step, Work},
    hazard::{Hazards, Uses},
    profile::Turns,
};
use crate::{
    Error, Result,
    gpu::{Access, Commands, Descriptors, FRAMES_IN_FLIGHT, Gpu, Pipeline, Target},
};

/// A step ready to be recorded.
pub(super) struct Built {
    pub(super) name: String,
    /// Number of the name, in order of first appearance.
    pub(super) name_row: u32,
    pub(super) label: CString,
    pub(super) command: Command,
    pub(super) uses: Vec<(usize, Uses)>,
}

pub(super) enum Command {
    Dispatch(Dispatch),
    Fill(Fill),
    Copy(Copy),
}

pub(super) struct Dispatch {
    pub(super) pipeline: Arc<Pipeline>,
    /// One a slot.
    pub(super) sets: [Option<vk::DescriptorSet>; FRAMES_IN_FLIGHT],
    pub(super) constants: Vec<u8>,
    pub(super) index_at: Option<usize>,
    pub(super) extent: Extent,
}

pub(super) fn build(builder: FrameBuilder) -> Result<Frame> {
    if let Some(error) = builder.error {
        return Err(error);
    }
    let FrameBuilder {
        gpu,
        name,
        steps,
        resources,
        ..
    } = builder;
    let passes = steps.iter().filter_map(|s| match &s.work {
        Work::Pass(pass) => Some(pass),
        _ => None,
    });
    let pipelines: Vec<_> = passes
        .map(|pass| {
            let pipeline = gpu.shared.pipeline(&pass.declaration, pass.variant)?;
            check(&gpu, pass, &pipeline, &resources).map(|()| pipeline)
        })
        .collect::<Result<_>>()?;
    let mut descriptors =
        Descriptors::new(&gpu.shared, &name, &pipelines, FRAMES_IN_FLIGHT as u32)?;
    let mut pipelines = pipelines.into_iter();
    let names = name_rows(&steps);
    let steps = steps.into_iter().zip(&names).map(|(step, name_row)| {
        let Step {
            name,
            label,
            work,
            uses,
        } = step;
        let command = match work {
            Work::Fill(fill) => Command::Fill(fill),
            Work::Copy(copy) => Command::Copy(copy),
            Work::Pass(pass) => Command::Dispatch(dispatch(
                pass,
                pipelines.next(),
                descriptors.as_mut(),
                &resources,
            )?),
        };
        let label = CString::new(label).map_err(|e| Error::argument(&*name, e.to_string()))?;
        Ok(Built {
            name: name.into_owned(),
            name_row: *name_row,
            label,
            command,
            uses,
        })
    });
    let steps: Vec<_> = steps.collect::<Result<_>>()?;
    let slot = || SlotState::new(Commands::new(&gpu.shared, &name)?, steps.len());
    let slots = [slot()?, slot()?];
    Ok(Frame {
        label: CString::new(&*name).map_err(|e| Error::argument(&*name, e.to_string()))?,
        all: [super::Span {
            steps: 0..steps.len(),
            index: 0,
        }],
        profile: None,
        turns: Turns::new(&names),
        turn: 0,
        hazards: Hazards::new(resources.len()),
        harvest: super::timings::Stamps::with_capacity(steps.len()),
        next: 0,
        begun: None,
        slots,
        steps,
        name,
        _descriptors: descriptors,
        resources,
        gpu,
    })
}

/// Numbers of the steps' names, in order of first appearance.
fn name_rows(steps: &[Step]) -> Vec<u32> {
    let mut names = Vec::new();
    let row = |step: &Step| {
        let row = names.iter().position(|name| *name == step.name);
        row.unwrap_or_else(|| {
            names.push(step.name.clone());
            names.len() - 1
        }) as u32
    };
    steps.iter().map(row).collect()
}

/// What the builder could not know before the pipeline was there.
fn check(gpu: &Gpu, pass: &Pass, pipeline: &Pipeline, resources: &[Resource]) -> Result<()> {
    let declaration = &pass.declaration;
    let refuse = |reason: String| {
        Err(Error::Pass {
            pass: declaration.name,
            reason,
        })
    };
    for (row, binding) in declaration.bindings.iter().enumerate() {
        let Some(resource) = pass.bound[row] else {
            return refuse(format!("binding {:?} is not bound", binding.name));
        };
        if let (Access::ImageWrite, Resource::Image(image)) = (binding.access, &resources[resource])
            && pipeline.formats[row] != Some(image.format())
        {
            let (is, wants) = (image.format(), pipeline.formats[row]);
            return refuse(format!(
                "{} is {is:?}, the shader's {} {wants:?}",
                image.name(),
                binding.name
            ));
        }
    }
    let (given, wanted) = (pass.constants.len(), declaration.constants as usize);
    if given != wanted {
        return refuse(format!(
            "{given} bytes of push constants are given, {wanted} declared"
        ));
    }
    if let Some(byte) = pass.index_at
        && (!byte.is_multiple_of(4) || byte.saturating_add(4) > given)
    {
        return refuse(format!(
            "no word at byte {byte} of {given} bytes of push constants"
        ));
    }
    match pass.extent {
        Some(Extent::Groups(groups)) => check_groups(gpu, declaration.name, groups),
        Some(Extent::Indirect(..)) => Ok(()),
        None => refuse("it has no extent: groups, items or indirect".into()),
    }
}

pub(super) fn check_groups(gpu: &Gpu, pass: &'static str, groups: [u32; 3]) -> Result<()> {
    let most = gpu.limits().max_compute_work_group_count;
    if groups.iter().zip(most).all(|(g, m)| *g <= m) {
        return Ok(());
    }
    let reason = format!("{groups:?} workgroups pass this device's {most:?}");
    Err(Error::Pass { pass, reason })
}

fn dispatch(
    pass: Pass,
    pipeline: Option<Arc<Pipeline>>,
    descriptors: Option<&mut Descriptors>,
    resources: &[Resource],
) -> Result<Dispatch> {
    let (Some(pipeline), Some(extent)) = (pipeline, pass.extent) else {
        return Err(Error::Pass {
            pass: pass.declaration.name,
            reason: "it has no pipeline or extent".into(),
        });
    };
    let mut sets = [None; FRAMES_IN_FLIGHT];
    if let Some(descriptors) = descriptors.filter(|_| !pass.bound.is_empty()) {
        for (slot, set) in sets.iter_mut().enumerate() {
            let bound = pass.bound.iter().flatten().map(|r| &resources[*r]);
            let targets: Vec<_> = bound.map(|r| target(r, slot)).collect();
            *set = Some(descriptors.set(&pipeline, &targets)?);
        }
    }
    Ok(Dispatch {
        pipeline,
        sets,
        constants: pass.constants,
        index_at: pass.index_at,
        extent,
    })
}

fn target(resource: &Resource, slot: usize) -> Target {
    match resource {
        Resource::Buffer(buffer) if buffer.is_hosted() => {
            Target::Bytes(buffer.raw(), buffer.bytes())
        }
        Resource::Buffer(buffer) => Target::Buffer(buffer.raw()),
        Resource::Ring(ring) => Target::Buffer(ring.0[slot].raw()),
        Resource::Image(image) => Target::Image(image.view()),
    }
}
