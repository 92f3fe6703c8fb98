//! Checks the steps of a frame and makes all that its submissions need.

use std::{ffi::CString, sync::Arc};

use super::{
    Frame, FrameBuilder, SlotState,
    builder::{Pass, Resource, Step, Work},
    hazard::{Hazards, Uses},
    profile::Turns,
    program::{Buffers, Built, Command, Copy, Dispatch, Extent, Fill, Program, Reach},
};
use crate::{
    Error, Result,
    gpu::{Access, Buffer, Commands, Descriptors, FRAMES_IN_FLIGHT, Gpu, Pipeline, Target},
};

pub(super) fn build(builder: FrameBuilder) -> Result<Frame> {
    if let Some(error) = builder.error {
        return Err(error);
    }
    let FrameBuilder {
        gpu,
        name,
        steps,
        resources,
        sections,
        ..
    } = builder;
    if let Some(section) = sections.iter().find(|s| s.end > steps.len()) {
        let reason = format!("steps {section:?} of {} are to be fixed", steps.len());
        return Err(Error::argument(format!("frame {name}"), reason));
    }
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
    let (names, rows) = names(&steps);
    let mut program = Program::default();
    for (step, name_row) in steps.into_iter().zip(&rows) {
        let command = match step.work {
            Work::Fill(fill) => Command::Fill(Fill {
                to: buffers(&resources, fill.to)?,
                offset: fill.offset,
                bytes: fill.bytes,
                value: fill.value,
            }),
            Work::Copy(copy) => Command::Copy(program.copy(copy, &resources)?),
            Work::Pass(pass) => {
                let (pipeline, descriptors) = (pipelines.next(), descriptors.as_mut());
                Command::Dispatch(program.dispatch(pass, pipeline, descriptors, &resources)?)
            }
        };
        let label = CString::new(step.label).map_err(|e| Error::argument(&*name, e.to_string()))?;
        let mapped = step
            .uses
            .iter()
            .filter(|u| resources[u.0 as usize].is_mapped());
        let mapped = mapped.fold(Uses::default(), |all, u| all.with(u.1.writes()));
        let first = program.uses.len() as u32;
        program.uses.extend(step.uses);
        program.steps.push(Built {
            command,
            uses: first..program.uses.len() as u32,
            mapped,
            name_row: *name_row,
            label,
        });
    }
    let count = program.steps.len();
    let slot = || SlotState::new(Commands::new(&gpu.shared, &name)?, count);
    let slots = [slot()?, slot()?];
    let mut frame = Frame {
        label: CString::new(&*name).map_err(|e| Error::argument(&*name, e.to_string()))?,
        all: [super::Span {
            steps: 0..count,
            index: 0,
        }],
        profile: None,
        turns: Turns::new(&rows),
        turn: 0,
        hazards: Hazards::new(resources.len()),
        harvest: super::timings::Stamps::with_capacity(count),
        next: 0,
        begun: None,
        slots,
        program,
        fixed: Vec::new(),
        names,
        name,
        _secondaries: None,
        _descriptors: descriptors,
        resources,
        gpu,
    };
    frame.fix(sections)?;
    Ok(frame)
}

/// The steps' names in order of first appearance, and each step's number in them.
fn names(steps: &[Step]) -> (Vec<String>, Vec<u32>) {
    let mut names: Vec<String> = Vec::new();
    let row = |step: &Step| {
        let row = names.iter().position(|name| *name == step.name);
        row.unwrap_or_else(|| {
            names.push(step.name.clone().into_owned());
            names.len() - 1
        }) as u32
    };
    let rows = steps.iter().map(row).collect();
    (names, rows)
}

/// The buffer that each slot uses of a resource.
fn buffers(resources: &[Resource], row: usize) -> Result<Buffers> {
    let raw = |slot| resources[row].buffer(slot).map(Buffer::raw);
    match (raw(0), raw(1)) {
        (Some(a), Some(b)) => Ok([a, b]),
        _ => Err(Error::argument(resources[row].name(), "no buffer")),
    }
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

impl Program {
    /// Adds the constants.
    fn dispatch(
        &mut self,
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
        let extent = match extent {
            Extent::Groups(groups) => Extent::Groups(groups),
            Extent::Indirect(row, at) => Extent::Indirect(buffers(resources, row)?, at),
        };
        let first = self.constants.len() as u32;
        self.constants.extend(pass.constants);
        Ok(Dispatch {
            bound: pipeline.bound(),
            pipeline,
            sets,
            constants: first..self.constants.len() as u32,
            index_at: pass.index_at.map(|byte| byte as u32),
            extent,
        })
    }

    /// Adds how far it may go.
    fn copy(&mut self, copy: Copy<usize>, resources: &[Resource]) -> Result<Copy<Buffers>> {
        let ends = [copy.from, copy.to].into_iter().zip(copy.strides);
        for (resource, stride) in ends {
            let room = resources[resource].bytes() - copy.bytes;
            if let Some(last) = room.checked_div(stride) {
                self.reaches.push(Reach {
                    step: self.steps.len(),
                    resource,
                    last: u32::try_from(last).unwrap_or(u32::MAX),
                });
            }
        }
        Ok(Copy {
            from: buffers(resources, copy.from)?,
            to: buffers(resources, copy.to)?,
            bytes: copy.bytes,
            strides: copy.strides,
        })
    }
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
