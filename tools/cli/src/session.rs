//! What every command that deforms needs: the model, its rig, the device, and deformers on it.

use std::{path::Path, sync::Arc, time::Instant};

use dermis::{
    Error, Result, asset,
    asset::Model,
    compose::{self, Operator},
    deformer::{Deformer, Device, Method, Settings},
    gpu::{DeviceSelector, Gpu, GpuOptions, Profile},
    report::DeviceReport,
    rig::{self, Primitive, Rig, Skeleton},
};

use crate::{
    console::{Console, complain},
    devices::cpu_report,
    options::{DeviceOptions, RigOptions},
    parse::DeviceChoice,
    progress::{Progress, Stage},
};

/// A character as its file has it.
#[derive(Debug)]
pub(crate) struct Character {
    pub(crate) model: Model,
    pub(crate) skeleton: Skeleton,
    loaded: Stage,
}

impl Character {
    /// Loads `file`.
    pub(crate) fn load(file: &Path) -> Result<Self> {
        let begin = Instant::now();
        let model = asset::load(file)?;
        let skeleton = Skeleton::from_model(&model)?;
        let loaded = Stage {
            name: "load",
            begin,
            end: Instant::now(),
        };
        Ok(Self {
            model,
            skeleton,
            loaded,
        })
    }
}

/// A character that is ready to be deformed.
pub(crate) struct Session {
    pub(crate) model: Model,
    pub(crate) rig: Arc<Rig>,
    pub(crate) device: Device,
    /// Stages of the preparation, for the profile.
    pub(crate) stages: Vec<Stage>,
}

impl Session {
    /// Opens the device and prepares the character, with progress on a terminal.
    ///
    /// Poses are chosen before: a wrong one need not wait for the preparation.
    pub(crate) fn open(
        character: Character,
        rig: &RigOptions,
        device: &DeviceOptions,
        profile: Profile,
        console: &Console,
    ) -> Result<Self> {
        let Character {
            model,
            skeleton,
            loaded,
        } = character;
        let primitives = primitives(rig.primitives.as_deref(), &skeleton)?;
        let device = open_device(device, profile, console)?;
        let (rig, mut stages) = prepare(&model, rig, primitives, console)?;
        stages.insert(0, loaded);
        for warning in &rig.warnings {
            console.note(format_args!("warning: {warning}"))?;
        }
        Ok(Self {
            model,
            rig: Arc::new(rig),
            device,
            stages,
        })
    }

    /// A deformer of this character.
    pub(crate) fn deformer(&self, method: Method) -> Result<Deformer> {
        self.deformer_of(method, 1)
    }

    /// A deformer of several instances of this character.
    pub(crate) fn deformer_of(&self, method: Method, instances: u32) -> Result<Deformer> {
        let settings = Settings {
            method,
            instances,
            ..Settings::default()
        };
        Deformer::new(&self.device, Arc::clone(&self.rig), &settings)
    }

    /// What the command ran on.
    pub(crate) fn device_report(&self) -> DeviceReport {
        device_report(&self.device)
    }

    /// The last word of a command: fails if the validation layer had something to say.
    pub(crate) fn finish(&self) -> Result<()> {
        check_validation(&self.device)
    }
}

/// Opens the device that the user asked for; says so when that is the slow one.
pub(crate) fn open_device(
    options: &DeviceOptions,
    profile: Profile,
    console: &Console,
) -> Result<Device> {
    let selector = match &options.device {
        DeviceChoice::Cpu => {
            console.note("computing on the CPU, without Vulkan: this is slow")?;
            return Ok(Device::Cpu);
        }
        DeviceChoice::Auto => DeviceSelector::Auto,
        DeviceChoice::Index(index) => DeviceSelector::Index(*index),
        DeviceChoice::Name(name) => DeviceSelector::Name(name.clone()),
    };
    let gpu = Gpu::new(&GpuOptions {
        device: selector,
        validation: options.validation,
        budget: options.budget,
        profile,
    });
    match gpu {
        Ok(gpu) => Ok(Device::Gpu(gpu)),
        Err(Error::NoDevice { reason })
            if options.device == DeviceChoice::Auto && !options.validation =>
        {
            console.note(format_args!(
                "no Vulkan device ({reason}): computing on the CPU, which is slow"
            ))?;
            Ok(Device::Cpu)
        }
        Err(error) => Err(error),
    }
}

/// The device that computes also draws; where that is the CPU, any Vulkan device does.
pub(crate) fn drawing_device(device: &Device, validation: bool) -> Result<Gpu> {
    if let Device::Gpu(gpu) = device {
        return Ok(gpu.clone());
    }
    let options = GpuOptions {
        validation,
        ..GpuOptions::default()
    };
    Gpu::new(&options).map_err(|error| match error {
        Error::NoDevice { reason } => Error::NoDevice {
            reason: format!("pictures are drawn with Vulkan even where the CPU computes: {reason}"),
        },
        other => other,
    })
}

/// The primitives of a file, checked against the character; none without a file.
pub(crate) fn primitives(file: Option<&Path>, skeleton: &Skeleton) -> Result<Vec<Primitive>> {
    let Some(file) = file else {
        return Ok(Vec::new());
    };
    let list = Primitive::read(file)?;
    Primitive::check(&list, skeleton).map_err(|e| e.in_file(file))?;
    Ok(list)
}

fn prepare(
    model: &Model,
    user: &RigOptions,
    primitives: Vec<Primitive>,
    console: &Console,
) -> Result<(Rig, Vec<Stage>)> {
    let progress = Progress::new(console);
    let options = rig::Options {
        joints: user.joint.clone(),
        openings: user.opening.clone(),
        controllers: user.controller.clone(),
        profile: read_profile(user)?,
        rigid: user.rigid.clone(),
        spines: user.spine.clone(),
        magnitude: user.magnitude,
        primitives,
        subdivide: user.subdivide,
        ..rig::Options::default()
    };
    let show = |p| progress.show(p);
    let rig = match &user.cache {
        Some(dir) => Rig::prepare_cached(dir, model, &options, &show),
        None => Rig::prepare(model, &options, &show),
    };
    let stages = progress.finish();
    let rig = rig.map_err(|e| match &user.primitives {
        Some(file) => e.in_file(file),
        None => e,
    });
    Ok((rig?, stages))
}

/// The user's profile curve, which some joint must use.
fn read_profile(user: &RigOptions) -> Result<Option<compose::Profile>> {
    let Some(path) = &user.profile else {
        return Ok(None);
    };
    if !user.joint.iter().any(|(_, o)| *o == Operator::Profile) {
        let reason = "no joint uses it; add --joint NAME=profile";
        return Err(Error::argument("--profile", reason));
    }
    compose::Profile::read(path).map(Some)
}

/// The device as a report; the CPU has one, too.
pub(crate) fn device_report(device: &Device) -> DeviceReport {
    match device {
        Device::Gpu(gpu) => gpu.report(),
        Device::Cpu => cpu_report(),
    }
}

/// Fails with the number of messages after it has shown them all.
pub(crate) fn check_validation(device: &Device) -> Result<()> {
    let Device::Gpu(gpu) = device else {
        return Ok(());
    };
    let messages = gpu.validation_messages();
    if messages.is_empty() {
        return Ok(());
    }
    for message in &messages {
        complain(format_args!("validation: {message}"));
    }
    let reason = format!("{} messages, listed above", messages.len());
    Err(Error::argument("--validation", reason))
}
