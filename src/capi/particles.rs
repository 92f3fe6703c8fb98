//! Particles that bounce off a level of a sphere-mesh.

use std::{ffi::c_void, sync::Arc};

use glam::Vec3;

use super::{
    embed::{HostOutput, dm_output_desc, handover, host_buffer, host_commands, layout},
    guard::{Fault, Outcome, dm_result, guard},
    handle::{self, dm_context, dm_level, dm_output, dm_particles},
    levels::{self, Opened},
    log::Logger,
    pointer::{self, structs},
};
use crate::{
    asset::ROW_LIMIT,
    deformer::Output,
    particles::{Particle, Particles, Settings},
    sphere_mesh::Shape,
};

/// How particles fly and bounce; dm_particle_settings_default fills it.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct dm_particle_settings {
    /// sizeof(dm_particle_settings).
    pub size: u32,
    /// Contacts of a particle in a frame, 1 to 64; after the last it stays with the surface until the frame ends.
    pub contacts: u32,
    /// Acceleration of all particles, units a second squared.
    pub gravity: [f32; 3],
    /// Share of the normal speed that a bounce leaves, 0 to 1.
    pub restitution: f32,
    /// Coulomb's coefficient of friction, 0 or more.
    pub friction: f32,
    /// 0.
    pub reserved: u32,
}

/// Particles, in the units of the sphere-mesh and in seconds.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct dm_particles_desc {
    /// sizeof(dm_particles_desc).
    pub size: u32,
    /// Number of particles.
    pub count: u32,
    /// 4 numbers a particle: its centre and its radius, 0 or more.
    pub positions: *const f32,
    /// 3 numbers a particle, units a second; NULL where all rest.
    pub velocities: *const f32,
}

/// Arrays that particles are written to; those that are NULL are left out.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct dm_flights {
    /// sizeof(dm_flights).
    pub size: u32,
    /// Rows that each array has, as many as there are particles.
    pub count: u32,
    /// 4 numbers a particle: its centre and its radius.
    pub positions: *mut f32,
    /// 3 numbers a particle, units a second.
    pub velocities: *mut f32,
    /// How often each has touched the level so far, and been pushed out of it.
    pub contacts: *mut u32,
}

structs!(dm_particle_settings, dm_particles_desc, dm_flights);

/// What the handle of particles stands for.
pub(super) struct Flying {
    particles: Particles,
    level: Arc<Opened>,
    /// The level on its way, kept, so that a frame allocates nothing.
    shape: Shape,
    logger: Arc<Logger>,
    context: dm_context,
}

/// Runs `work` on particles whose device is not lost, then tells what happened while nothing is locked.
fn with<T>(particles: dm_particles, work: impl FnOnce(&mut Flying) -> Outcome<T>) -> Outcome<T> {
    let object = handle::get(particles)?;
    let (logger, outcome) = {
        let mut flying = handle::lock(&object)?;
        let logger = flying.logger.clone();
        let outcome = logger.check().and_then(|()| work(&mut flying));
        (logger, outcome)
    };
    logger.finish(outcome)
}

impl Flying {
    /// Moves the kept shape to a time.
    fn go_to(&mut self, time: f64) -> Outcome {
        levels::check_time(time)?;
        let Opened { hierarchy, level } = &*self.level;
        self.shape.go_to(hierarchy, level, time);
        Ok(())
    }
}

/// Fills settings with the defaults, those that NULL in their place has.
///
/// out: size set by the caller, the rest is filled.
///
/// Threads: any. Returns DM_OK, DM_ERROR_NULL or DM_ERROR_STRUCT_SIZE.
///
/// # Safety
/// out is NULL or valid.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dm_particle_settings_default(out: *mut dm_particle_settings) -> dm_result {
    guard("dm_particle_settings_default", || {
        let Settings {
            gravity,
            restitution,
            friction,
            contacts,
        } = Settings::default();
        let settings = dm_particle_settings {
            size: size_of::<dm_particle_settings>() as u32,
            contacts,
            gravity: gravity.to_array(),
            restitution,
            friction,
            reserved: 0,
        };
        // SAFETY: the caller's promise.
        unsafe {
            pointer::check(out, "out")?;
            pointer::put(out, settings);
        }
        Ok(())
    })
}

/// Makes particles in a context, around a level of a sphere-mesh.
///
/// time: in frames, where the level is (dm_spheres.time). desc: copied with its arrays. settings: NULL for the defaults; copied.
/// out: receives the handle, which is the caller's to destroy. The particles keep what they need of context and level, which may be
/// destroyed before them.
///
/// Threads: any; other calls on the context wait meanwhile, and it waits for the device.
///
/// Returns DM_OK; DM_ERROR_NULL; DM_ERROR_STRUCT_SIZE; DM_ERROR_HANDLE; DM_ERROR_ARGUMENT naming the particle, sphere or setting that
/// is not finite or out of range; DM_ERROR_MEMORY; DM_ERROR_VULKAN; DM_ERROR_DEVICE_LOST; DM_ERROR_PANIC.
///
/// # Safety
/// desc is NULL or valid, and each of its arrays is NULL or has as many rows as it says; settings and out are NULL or valid.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dm_particles_create(
    context: dm_context,
    level: dm_level,
    time: f64,
    desc: *const dm_particles_desc,
    settings: *const dm_particle_settings,
    out: *mut dm_particles,
) -> dm_result {
    guard("dm_particles_create", || {
        // SAFETY: the caller's promise, here and below.
        let (rows, settings) = unsafe {
            let settings = match settings.is_null() {
                true => Settings::default(),
                false => read(&pointer::read(settings, "settings")?)?,
            };
            (particles(desc)?, settings)
        };
        pointer::not_null(out, "out")?;
        let level = levels::opened(level)?;
        let shape = level.at(time)?;
        let (particles, logger) = super::context::with(context, |context| {
            let particles = Particles::new(&context.device, &shape, &rows, &settings)?;
            Ok((particles, context.logger.clone()))
        })?;
        let handle: dm_particles = handle::insert(Flying {
            particles,
            level,
            shape,
            logger,
            context,
        })?;
        // SAFETY: see above.
        unsafe { pointer::put(out, handle) };
        Ok(())
    })
}

/// Destroys particles.
///
/// Threads: any; a call that uses them on another thread completes first. Does not wait for the device: memory goes when the
/// device is done with it.
///
/// Returns DM_OK, or DM_ERROR_HANDLE where there are no such particles (any more).
#[unsafe(no_mangle)]
pub extern "C" fn dm_particles_destroy(particles: dm_particles) -> dm_result {
    guard("dm_particles_destroy", || handle::destroy(particles))
}

/// Lets particles fly for some seconds, while the level goes straight to where it is at a time. They bounce off its spheres,
/// capsules and thick triangles, as often as their settings allow; nothing tunnels through, however fast, and none is inside at the
/// end. Submits to the context's queue and does not wait, unless two frames are on their way already; on the CPU it computes.
///
/// time: in frames, where the level is at the end. seconds: above 0, up to 1000.
///
/// Threads: any.
///
/// Returns DM_OK; DM_ERROR_HANDLE; DM_ERROR_ARGUMENT for a time that is not finite, or seconds out of range; DM_ERROR_VULKAN;
/// DM_ERROR_MEMORY; DM_ERROR_DEVICE_LOST; DM_ERROR_PANIC. Where it is not DM_OK neither particles nor level have moved.
#[unsafe(no_mangle)]
pub extern "C" fn dm_particles_advance(
    particles: dm_particles,
    time: f64,
    seconds: f32,
) -> dm_result {
    guard("dm_particles_advance", || {
        with(particles, |flying| {
            flying.go_to(time)?;
            Ok(flying.particles.advance(&flying.shape.balls, seconds)?)
        })
    })
}

/// Has the level at a time at once, for cuts: no particle is hit on the way. Those inside are pushed out at the end of the next
/// frame.
///
/// time: in frames.
///
/// Threads: any. Returns DM_OK, DM_ERROR_HANDLE, DM_ERROR_ARGUMENT for a time that is not finite, DM_ERROR_DEVICE_LOST or
/// DM_ERROR_PANIC.
#[unsafe(no_mangle)]
pub extern "C" fn dm_particles_place(particles: dm_particles, time: f64) -> dm_result {
    guard("dm_particles_place", || {
        with(particles, |flying| {
            flying.go_to(time)?;
            Ok(flying.particles.place(&flying.shape.balls)?)
        })
    })
}

/// Reads particles after the last frame; waits for it.
///
/// flights: where to put them; the arrays are the caller's.
///
/// Threads: any.
///
/// Returns DM_OK; DM_ERROR_NULL; DM_ERROR_STRUCT_SIZE; DM_ERROR_HANDLE; DM_ERROR_SIZE where flights has another number of rows;
/// DM_ERROR_VULKAN; DM_ERROR_MEMORY; DM_ERROR_DEVICE_LOST; DM_ERROR_PANIC.
///
/// # Safety
/// flights is NULL or valid, and each of its arrays is NULL or has as many rows as it says.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dm_particles_read(
    particles: dm_particles,
    flights: *const dm_flights,
) -> dm_result {
    guard("dm_particles_read", || {
        // SAFETY: the caller's promise, here and below.
        let out = unsafe { pointer::read(flights, "flights")? };
        with(particles, |flying| {
            let (given, wanted) = (out.count as usize, flying.particles.count() as usize);
            if given != wanted {
                return Err(Fault::size("flights.count", given, wanted));
            }
            let rows = flying.particles.read()?;
            let place = |p: &Particle| p.position.extend(p.radius).to_array();
            let places: Vec<[f32; 4]> = rows.iter().map(place).collect();
            let velocities: Vec<[f32; 3]> = rows.iter().map(|p| p.velocity.to_array()).collect();
            let contacts: Vec<u32> = rows.iter().map(|p| p.contacts).collect();
            // SAFETY: see above.
            unsafe {
                pointer::copy_wanted(&places, out.positions.cast());
                pointer::copy_wanted(&velocities, out.velocities.cast());
                pointer::copy_wanted(&contacts, out.contacts);
            }
            Ok(())
        })
    })
}

/// Replaces all particles; waits for the last frame. They have not touched anything yet.
///
/// desc: as many as there are; copied with its arrays.
///
/// Threads: any.
///
/// Returns DM_OK; DM_ERROR_NULL; DM_ERROR_STRUCT_SIZE; DM_ERROR_HANDLE; DM_ERROR_ARGUMENT for another number of particles, or naming
/// one that is not finite or out of range; DM_ERROR_VULKAN, DM_ERROR_MEMORY or DM_ERROR_DEVICE_LOST, by which some may be replaced and
/// others not until a call succeeds; DM_ERROR_PANIC.
///
/// # Safety
/// desc is NULL or valid, and each of its arrays is NULL or has as many rows as it says.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dm_particles_write(
    particles: dm_particles,
    desc: *const dm_particles_desc,
) -> dm_result {
    guard("dm_particles_write", || {
        // SAFETY: the caller's promise.
        let rows = unsafe { self::particles(desc)? };
        with(particles, |flying| Ok(flying.particles.write(&rows)?))
    })
}

/// Makes a buffer of the host's an output of particles: dm_particles_record writes one vertex a particle, its position and, where
/// the description has normals, which are DM_NORMAL_F32 then, its velocity in their place.
///
/// context: the particles', made by dm_context_adopt or of the same device. desc: copied; the buffer stays the host's; its
/// instance_stride is of no meaning. out: receives the handle, which is the caller's to destroy before the buffer.
///
/// Threads: any. Submits nothing.
///
/// Returns DM_OK; DM_ERROR_NULL; DM_ERROR_STRUCT_SIZE; DM_ERROR_HANDLE; DM_ERROR_FOREIGN where the particles are of another
/// context; DM_ERROR_ARGUMENT where the vertices do not fit, for normals in bytes, for a queue family that the device has not, or on
/// the CPU; DM_ERROR_MEMORY for a buffer longer than a shader can bind; DM_ERROR_VULKAN; DM_ERROR_DEVICE_LOST; DM_ERROR_PANIC.
///
/// # Safety
/// desc and out are NULL or valid; the buffer is valid and as long as desc says until the output is destroyed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dm_particles_output(
    context: dm_context,
    particles: dm_particles,
    desc: *const dm_output_desc,
    out: *mut dm_output,
) -> dm_result {
    guard("dm_particles_output", || {
        // SAFETY: the caller's promise, here and below.
        let desc = unsafe { pointer::read(desc, "desc")? };
        pointer::not_null(out, "out")?;
        let gpu = super::context::gpu_of(context)?;
        let layout = layout(&desc)?;
        // SAFETY: see above.
        let buffer = unsafe { host_buffer(&gpu, &desc)? };
        let output = with(particles, |flying| {
            if flying.context != context {
                let message = "the particles are of another context";
                return Err(Fault::new(dm_result::DM_ERROR_FOREIGN, message));
            }
            Ok(flying
                .particles
                .output(&buffer, &layout, &handover(&desc))?)
        })?;
        let source = particles.id;
        let handle = handle::insert(HostOutput { output, source })?;
        // SAFETY: see above.
        unsafe { pointer::put(out, handle) };
        Ok(())
    })
}

/// Records a frame into a command buffer of the host's: what dm_particles_advance submits, and the writing of the output.
/// Submits nothing, waits for nothing, allocates nothing.
///
/// The command buffer (VkCommandBuffer) before and after: as in dm_frame_record. The host submits it to the context's queue, once,
/// and frames in the order of their recording.
///
/// frame_slot: below DM_FRAME_SLOTS; what was recorded with it before has to be done, since its level is overwritten. time, seconds:
/// as in dm_particles_advance. output: of these particles, or zero for none.
///
/// Threads: any that may record into the command buffer.
///
/// Returns DM_OK; DM_ERROR_NULL; DM_ERROR_HANDLE; DM_ERROR_FOREIGN where the output is of something else; DM_ERROR_ARGUMENT for the
/// slot, the time or the seconds, or on the CPU; DM_ERROR_DEVICE_LOST where another call has found it; DM_ERROR_PANIC. Where it is
/// not DM_OK nothing is recorded, and the level has not moved.
///
/// # Safety
/// The command buffer is NULL or in the state above; particles and output are not destroyed before it is done.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dm_particles_record(
    particles: dm_particles,
    command_buffer: *mut c_void,
    frame_slot: u32,
    time: f64,
    seconds: f32,
    output: dm_output,
) -> dm_result {
    guard("dm_particles_record", || {
        // SAFETY: the caller's promise.
        let commands = unsafe { host_commands(command_buffer)? };
        let record = |output: Option<&mut Output>| {
            with(particles, |flying| {
                flying.go_to(time)?;
                let (slot, balls) = (frame_slot as usize, &flying.shape.balls);
                let particles = &mut flying.particles;
                Ok(particles.record(&commands, slot, balls, seconds, output)?)
            })
        };
        if output.id == 0 {
            return record(None);
        }
        handle::with(output, |host| {
            if host.source != particles.id {
                handle::get(particles)?;
                let message = "the output is of something else";
                return Err(Fault::new(dm_result::DM_ERROR_FOREIGN, message));
            }
            record(Some(&mut host.output))
        })
    })
}

fn read(given: &dm_particle_settings) -> Outcome<Settings> {
    if given.reserved != 0 {
        return Err(Fault::argument("settings.reserved", "it has to be 0"));
    }
    Ok(Settings {
        gravity: Vec3::from_array(given.gravity),
        restitution: given.restitution,
        friction: given.friction,
        contacts: given.contacts,
    })
}

/// # Safety
/// `desc` is NULL or valid, and each of its arrays is NULL or has as many rows as it says.
unsafe fn particles(desc: *const dm_particles_desc) -> Outcome<Vec<Particle>> {
    // SAFETY: the caller's promise, here and below.
    let desc = unsafe { pointer::read(desc, "desc")? };
    let count = desc.count as usize;
    if !(1..=ROW_LIMIT).contains(&count) {
        let reason = format!("{count} is not in 1 to {ROW_LIMIT}");
        return Err(Fault::argument("desc.count", reason));
    }
    // SAFETY: see above.
    let positions: Vec<[f32; 4]> =
        unsafe { pointer::array(desc.positions.cast(), count, "desc.positions")? };
    let velocities: Vec<[f32; 3]> = match desc.velocities.is_null() {
        true => vec![[0.0; 3]; count],
        // SAFETY: see above.
        false => unsafe { pointer::array(desc.velocities.cast(), count, "desc.velocities")? },
    };
    let rows = positions.iter().zip(&velocities);
    let particle = |(p, v): (&[f32; 4], &[f32; 3])| Particle {
        position: Vec3::from_slice(p),
        radius: p[3],
        velocity: Vec3::from_array(*v),
        contacts: 0,
    };
    Ok(rows.map(particle).collect())
}
