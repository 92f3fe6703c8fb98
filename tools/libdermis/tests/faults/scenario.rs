//! What a program does with dermis, from the first call to the last, when any call may fail.
// Pointers are NULL or to what lives until the call returns; Vulkan's handles live as long as the host.
#![allow(clippy::undocumented_unsafe_blocks)]

use std::{
    cell::{Cell, RefCell},
    ptr::{null, null_mut},
};

use ash::vk::{self, Handle as _};
use dermis::capi::{dm_result::*, *};

use crate::{
    fine,
    host_device::HostDevice,
    last_error,
    state::{self, Fault},
};

/// How a program comes to its device.
pub(crate) trait Way {
    fn create(&self, out: &mut dm_context) -> dm_result;
    /// The host, where the device is its own.
    fn host(&self) -> Option<&HostDevice>;
}

/// A character in poses.
pub(crate) struct Character {
    pub(crate) rig: dm_rig,
    pub(crate) method: u32,
    pub(crate) vertices: u32,
    pub(crate) poses: Vec<Vec<f32>>,
    /// A sphere-mesh's level that particles bounce off.
    pub(crate) level: dm_level,
}

/// Particles over the level: positions with radii, velocities.
const PLACES: [f32; 12] = [1.0, 1.0, 0.0, 0.1, 2.0, 1.0, 0.1, 0.1, 3.0, 1.0, 0.0, 0.05];
const SPEEDS: [f32; 9] = [0.0, -9.0, 0.0, 0.0, -9.0, 0.0, 0.0, -9.0, 0.0];

fn flying() -> dm_particles_desc {
    dm_particles_desc {
        size: size_of::<dm_particles_desc>() as u32,
        count: 3,
        positions: PLACES.as_ptr(),
        velocities: SPEEDS.as_ptr(),
    }
}

/// The device is lost: nothing can be done any more but to destroy.
pub(crate) struct Lost;

/// What came of calls of dermis.
#[derive(Default)]
pub(crate) struct Run {
    /// Those that failed, with their messages.
    pub(crate) failures: RefCell<Vec<(dm_result, String)>>,
    /// Bits of all skins that were read or written into the host's buffer.
    pub(crate) bits: RefCell<Vec<Vec<u32>>>,
}

impl Run {
    /// A call that may fail. Where memory ran out once, the same call succeeds when it is made again.
    fn step(&self, call: impl Fn() -> dm_result) -> Result<(), Lost> {
        let result = call();
        if result == DM_OK {
            return Ok(());
        }
        self.failures.borrow_mut().push((result, last_error()));
        if result == DM_ERROR_DEVICE_LOST {
            return Err(Lost);
        }
        fine(call());
        Ok(())
    }

    /// A call that may fail, made once; true where it did not.
    fn once(&self, call: impl Fn() -> dm_result) -> bool {
        let result = call();
        if result != DM_OK {
            self.failures.borrow_mut().push((result, last_error()));
        }
        result == DM_OK
    }

    fn keep(&self, words: Vec<u32>) {
        self.bits.borrow_mut().push(words);
    }
}

/// Objects of dermis on a device.
pub(crate) struct Objects<'a> {
    way: &'a dyn Way,
    character: &'a Character,
    context: Cell<dm_context>,
    deformer: Cell<dm_deformer>,
    output: Cell<dm_output>,
    particles: Cell<dm_particles>,
}

/// Calls `make` for a handle, which is kept where there is one.
fn handle<T: Default + Copy>(into: &Cell<T>, make: impl Fn(&mut T) -> dm_result) -> dm_result {
    let mut out = T::default();
    let result = make(&mut out);
    if result == DM_OK {
        into.set(out);
    }
    result
}

impl<'a> Objects<'a> {
    /// None yet.
    pub(crate) fn new(way: &'a dyn Way, character: &'a Character) -> Self {
        Self {
            way,
            character,
            context: Cell::default(),
            deformer: Cell::default(),
            output: Cell::default(),
            particles: Cell::default(),
        }
    }

    pub(crate) fn open(&self, run: &Run) -> Result<(), Lost> {
        run.step(|| handle(&self.context, |out| self.way.create(out)))
    }

    pub(crate) fn create(&self, run: &Run) -> Result<(), Lost> {
        run.step(|| self.create_deformer())?;
        run.step(|| self.create_particles())?;
        match self.way.host() {
            Some(host) => run.step(|| self.create_output(host)),
            None => Ok(()),
        }
    }

    /// As [`Objects::create`], but what fails is not done again.
    pub(crate) fn try_create(&self, run: &Run) -> Result<(), Lost> {
        if run.once(|| self.create_deformer())
            && run.once(|| self.create_particles())
            && let Some(host) = self.way.host()
        {
            run.once(|| self.create_output(host));
        }
        Ok(())
    }

    /// One frame, submitted.
    pub(crate) fn one_frame(&self, run: &Run) -> Result<(), Lost> {
        run.step(|| self.advance(&self.character.poses[0]))
    }

    /// Every function of a deformer, from rest on.
    pub(crate) fn work(&self, run: &Run) -> Result<(), Lost> {
        let poses = &self.character.poses;
        run.step(|| dm_deformer_reset(self.deformer.get()))?;
        if let Some(host) = self.way.host() {
            for (frame, pose) in poses[..3].iter().enumerate() {
                self.record(run, host, frame as u32 % 2, pose)?;
            }
            run.keep(host.words(6 * self.character.vertices as usize));
        }
        run.step(|| self.advance(&poses[3]))?;
        let state = self.save(run)?;
        run.step(|| self.advance(&poses[4]))?;
        self.read(run)?;
        run.step(|| self.memory())?;
        run.step(|| self.iterations())?;
        run.step(|| self.timings())?;
        let (at, bytes) = (state.as_ptr().cast(), state.len());
        run.step(|| unsafe { dm_deformer_restore(self.deformer.get(), at, bytes) })?;
        run.step(|| self.advance(&poses[4]))?;
        self.read(run)?;
        self.fly(run)
    }

    /// Every function of particles, from their beginning on.
    fn fly(&self, run: &Run) -> Result<(), Lost> {
        let particles = self.particles.get();
        run.step(|| dm_particles_place(particles, 0.0))?;
        run.step(|| unsafe { dm_particles_write(particles, &flying()) })?;
        run.step(|| dm_particles_advance(particles, 0.5, 0.1))?;
        if let Some(host) = self.way.host() {
            let mut recorded = Ok(());
            host.run(|| recorded = run.step(|| self.record_particles(host)));
            recorded?;
        }
        run.step(|| dm_particles_advance(particles, 2.0, 0.1))?;
        let places = RefCell::new(PLACES);
        run.step(|| self.read_particles(&mut places.borrow_mut()))?;
        let bits = places.into_inner().map(f32::to_bits);
        assert_ne!(bits, PLACES.map(f32::to_bits));
        run.keep(bits.to_vec());
        Ok(())
    }

    fn create_particles(&self) -> dm_result {
        let (context, level) = (self.context.get(), self.character.level);
        handle(&self.particles, |out| unsafe {
            dm_particles_create(context, level, 0.0, &flying(), null(), out)
        })
    }

    fn record_particles(&self, host: &HostDevice) -> dm_result {
        let commands = host.commands.as_raw() as *mut _;
        let (particles, none) = (self.particles.get(), dm_output::default());
        unsafe { dm_particles_record(particles, commands, 0, 1.0, 0.1, none) }
    }

    fn read_particles(&self, places: &mut [f32; 12]) -> dm_result {
        let out = dm_flights {
            size: size_of::<dm_flights>() as u32,
            count: 3,
            positions: places.as_mut_ptr(),
            velocities: null_mut(),
            contacts: null_mut(),
        };
        unsafe { dm_particles_read(self.particles.get(), &out) }
    }

    fn create_deformer(&self) -> dm_result {
        let character = self.character;
        let mut settings: dm_settings = unsafe { std::mem::zeroed() };
        settings.size = size_of::<dm_settings>() as u32;
        fine(unsafe { dm_settings_default(&mut settings) });
        settings.method = character.method;
        let context = self.context.get();
        handle(&self.deformer, |out| unsafe {
            dm_deformer_create(context, character.rig, &settings, out)
        })
    }

    fn create_output(&self, host: &HostDevice) -> dm_result {
        let (context, deformer) = (self.context.get(), self.deformer.get());
        handle(&self.output, |out| unsafe {
            dm_output_create(context, deformer, &host.output(), out)
        })
    }

    fn record(&self, run: &Run, host: &HostDevice, slot: u32, pose: &[f32]) -> Result<(), Lost> {
        let mut recorded = Ok(());
        host.run(|| recorded = run.step(|| self.record_call(host, slot, pose)));
        recorded
    }

    fn record_call(&self, host: &HostDevice, slot: u32, pose: &[f32]) -> dm_result {
        let (deformer, output) = (self.deformer.get(), self.output.get());
        let commands = host.commands.as_raw() as *mut _;
        unsafe {
            dm_frame_record(
                deformer,
                commands,
                slot,
                pose.as_ptr(),
                pose.len() / 16,
                output,
            )
        }
    }

    fn advance(&self, pose: &[f32]) -> dm_result {
        unsafe { dm_deformer_advance(self.deformer.get(), pose.as_ptr(), pose.len() / 16) }
    }

    fn save(&self, run: &Run) -> Result<Vec<u8>, Lost> {
        let (deformer, needed) = (self.deformer.get(), Cell::new(0));
        run.step(|| {
            handle(&needed, |out| unsafe {
                dm_deformer_save(deformer, null_mut(), 0, out)
            })
        })?;
        let bytes = RefCell::new(vec![0u8; needed.get()]);
        run.step(|| {
            let mut bytes = bytes.borrow_mut();
            let out = bytes.as_mut_ptr().cast();
            unsafe { dm_deformer_save(deformer, out, bytes.len(), null_mut()) }
        })?;
        Ok(bytes.into_inner())
    }

    fn read(&self, run: &Run) -> Result<(), Lost> {
        let positions = RefCell::new(vec![0f32; 3 * self.character.vertices as usize]);
        run.step(|| self.read_call(&mut positions.borrow_mut()))?;
        run.keep(positions.into_inner().iter().map(|x| x.to_bits()).collect());
        Ok(())
    }

    fn read_call(&self, positions: &mut [f32]) -> dm_result {
        let mut skin: dm_skin = unsafe { std::mem::zeroed() };
        skin.size = size_of::<dm_skin>() as u32;
        (skin.vertices, skin.positions) = (self.character.vertices, positions.as_mut_ptr());
        unsafe { dm_deformer_read(self.deformer.get(), &skin) }
    }

    fn memory(&self) -> dm_result {
        let size = size_of::<dm_memory>() as u32;
        let mut out = dm_memory {
            size,
            ..Default::default()
        };
        unsafe { dm_context_memory(self.context.get(), &mut out) }
    }

    fn iterations(&self) -> dm_result {
        let size = size_of::<dm_iterations>() as u32;
        let mut out = dm_iterations {
            size,
            ..Default::default()
        };
        unsafe { dm_deformer_iterations(self.deformer.get(), &mut out) }
    }

    fn timings(&self) -> dm_result {
        let size = size_of::<dm_timings>() as u32;
        let mut out = dm_timings {
            size,
            ..Default::default()
        };
        unsafe { dm_deformer_timings(self.deformer.get(), &mut out) }
    }

    /// Every call on a lost device says so, and does nothing else.
    pub(crate) fn all_refuse(&self) {
        let lost = |result: dm_result| assert_eq!(result, DM_ERROR_DEVICE_LOST, "{}", last_error());
        if self.context.get() == dm_context::default() {
            return;
        }
        lost(self.memory());
        lost(unsafe { dm_context_allocations(self.context.get(), Some(never), null_mut()) });
        lost(self.create_deformer());
        lost(self.create_particles());
        let particles = self.particles.get();
        if particles != dm_particles::default() {
            lost(dm_particles_advance(particles, 0.0, 0.1));
            lost(dm_particles_place(particles, 0.0));
            lost(unsafe { dm_particles_write(particles, &flying()) });
            lost(self.read_particles(&mut [0.0; 12]));
            if let Some(host) = self.way.host() {
                lost(self.record_particles(host));
            }
        }
        let deformer = self.deformer.get();
        if deformer == dm_deformer::default() {
            return;
        }
        let pose = &self.character.poses[0];
        lost(self.advance(pose));
        lost(self.read_call(&mut vec![0.0; 3 * self.character.vertices as usize]));
        lost(self.iterations());
        lost(self.timings());
        lost(dm_deformer_reset(deformer));
        lost(unsafe { dm_deformer_save(deformer, null_mut(), 0, &mut 0) });
        lost(unsafe { dm_deformer_restore(deformer, [0u8; 4].as_ptr().cast(), 4) });
        if let Some(host) = self.way.host() {
            lost(self.create_output(host));
            lost(self.record_call(host, 0, pose));
        }
    }

    /// A reset that fails halfway leaves no state, which is told until it is done again (tracking).
    pub(crate) fn break_state(&self) {
        state::begin(Some(Fault {
            name: "vkQueueSubmit",
            after: 2,
            code: vk::Result::ERROR_OUT_OF_HOST_MEMORY,
        }));
        let (deformer, pose) = (self.deformer.get(), &self.character.poses[0]);
        assert_eq!(dm_deformer_reset(deformer), DM_ERROR_MEMORY);
        let saved = || unsafe { dm_deformer_save(deformer, null_mut(), 0, &mut 0) };
        for refused in [self.advance(pose), saved()] {
            assert_eq!(refused, DM_ERROR_ARGUMENT);
            assert!(last_error().contains("failed halfway"), "{}", last_error());
        }
        fine(dm_deformer_reset(deformer));
        fine(self.advance(pose));
        fine(saved());
    }

    /// Destroys deformer, output and particles.
    pub(crate) fn clear(&self) {
        let output = self.output.take();
        if output != dm_output::default() {
            fine(dm_output_destroy(output));
        }
        let particles = self.particles.take();
        if particles != dm_particles::default() {
            fine(dm_particles_destroy(particles));
        }
        let deformer = self.deformer.take();
        if deformer != dm_deformer::default() {
            fine(dm_deformer_destroy(deformer));
        }
    }

    /// Destroys everything.
    pub(crate) fn close(&self) {
        self.clear();
        let context = self.context.take();
        if context != dm_context::default() {
            fine(dm_context_destroy(context));
        }
    }

    /// What is left of dermis' own when no deformer is, as soon as the device is done.
    pub(crate) fn settled(&self) -> std::collections::BTreeMap<&'static str, u32> {
        for _ in 0..1000 {
            let mut out = dm_memory {
                size: size_of::<dm_memory>() as u32,
                ..Default::default()
            };
            fine(unsafe { dm_context_memory(self.context.get(), &mut out) });
            if out.total == 0 {
                break;
            }
            std::thread::sleep(std::time::Duration::from_millis(1));
        }
        state::live()
    }
}

unsafe extern "C" fn never(_: *mut std::ffi::c_void, _: *const i8, _: *const i8, _: u64) {
    panic!("a lost device reports no allocations");
}
