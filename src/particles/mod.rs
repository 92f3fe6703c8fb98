//! Particles that fall on an animated sphere-mesh and bounce off it, on a device (sphere-meshes 2016, section 6.1).
//!
//! A [`Shape`] of any level goes from pose to pose; [`Particles::advance`] takes the particles along.
//! Everything is in the units of the shape and in seconds, in single precision: best where the shape is not far from the origin.

mod embed;
mod machine;
mod settings;

use std::time::Instant;

use glam::Vec3;

pub use settings::Settings;

use crate::{
    Error, Result,
    deformer::Device,
    report::{FrameTimings, MemoryReport},
    sphere_mesh::{Ball, Moving, Shape},
};
use machine::Machine;

/// A sphere that flies.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Particle {
    /// Centre.
    pub position: Vec3,
    /// Radius, 0 or more.
    pub radius: f32,
    /// Velocity, units a second.
    pub velocity: Vec3,
    /// How often it has touched the sphere-mesh so far, and been pushed out of it.
    pub contacts: u32,
}

/// Particles on a device, and the sphere-mesh that they bounce off.
///
/// A particle flies along the chord of its parabola until it first touches, in closed form: nothing tunnels through, however fast,
/// but a point that a frame ends on a sheet without thickness, where neither side is inside.
/// There it loses the share of its normal speed that the restitution does not keep, and slides on against friction; then it flies
/// on, up to [`Settings::contacts`] times a frame, and with the surface that it touched last for the rest. What the sphere-mesh
/// does between two poses is a straight way of every sphere: a particle meets each solid in the frame of reference that moves with
/// the solid's point nearest to it, and bounces off with the speed of what hit it. At the end of a frame no particle is deeper inside
/// the new pose than 5e-6 of the size of it, the particle's radius and greatest coordinate together: what still is, as when it began
/// there, is pushed out along the normal of the solid that holds it deepest. Without motion of the sphere-mesh, kinetic and
/// potential energy together never grow, but for what rounding and such a push add.
///
/// The same device, driver and input give the same bits. Particles do not touch each other.
pub struct Particles {
    settings: Settings,
    moving: Moving,
    machine: Machine,
    count: u32,
    record_ns: u64,
}

/// Greatest coordinate, radius and speed: squares of squares are finite in single precision.
const GREATEST: f32 = 1e8;

/// Longest frame, seconds.
const LONGEST: f32 = 1e3;

impl Particles {
    /// Uploads the particles, around the shape as it is.
    ///
    /// # Errors
    /// [`Error::Argument`] naming a sphere, particle or setting that is out of range, or where there are no particles; memory,
    /// Vulkan and shader errors.
    pub fn new(
        device: &Device,
        shape: &Shape,
        particles: &[Particle],
        settings: &Settings,
    ) -> Result<Self> {
        settings.check()?;
        check(particles)?;
        let count = u32::try_from(particles.len()).ok().filter(|n| *n > 0);
        let count = count.ok_or_else(|| Error::argument("particles", "1 to 2^32 - 1 can fly"))?;
        let moving = Moving::new(shape)?;
        let mut made = Self {
            machine: Machine::new(device, moving.primitives().len(), count)?,
            settings: *settings,
            moving,
            count,
            record_ns: 0,
        };
        made.write(particles)?;
        Ok(made)
    }

    /// Lets the particles fly for some seconds, while the shape's spheres go straight to `balls`, as many as it has. On a GPU the
    /// work is submitted, not waited for.
    ///
    /// # Errors
    /// [`Error::Argument`] naming what is out of range: spheres, or the seconds (above 0, up to 1000); Vulkan errors. Neither
    /// particles nor shape have moved then.
    pub fn advance(&mut self, balls: &[Ball], seconds: f32) -> Result<()> {
        let begin = Instant::now();
        let constants = self.go(balls, seconds)?;
        let done = self.machine.advance(self.moving.primitives(), &constants);
        self.record_ns = begin.elapsed().as_nanos() as u64;
        done.inspect_err(|_| self.moving.turn_back())
    }

    /// Has the shape's spheres at `balls` at once, for cuts: no particle is hit on the way. Those inside are pushed out at the end
    /// of the next frame.
    ///
    /// # Errors
    /// [`Error::Argument`] naming a sphere that is out of range, or for another number of them.
    pub fn place(&mut self, balls: &[Ball]) -> Result<()> {
        self.moving.go_to(balls)
    }

    /// The shape on its way, and what the pass is to know of it.
    fn go(&mut self, balls: &[Ball], seconds: f32) -> Result<crate::pass::particles::Constants> {
        if !(seconds > 0.0 && seconds <= LONGEST) {
            let reason = format!("{seconds}, but a frame has more than 0, and up to {LONGEST}");
            return Err(Error::argument("seconds", reason));
        }
        self.moving.go_to(balls)?;
        Ok(crate::pass::particles::Constants {
            gravity: self.settings.gravity.to_array(),
            seconds,
            restitution: self.settings.restitution,
            friction: self.settings.friction,
            size: self.moving.size() as f32,
            count: self.count,
            solids: self.moving.primitives().len() as u32,
            contacts: self.settings.contacts,
            carries: if self.moving.moves() { CARRIES } else { 0 },
        })
    }

    /// Waits until the last frame is done.
    ///
    /// # Errors
    /// Vulkan errors.
    pub fn wait(&mut self) -> Result<()> {
        self.machine.wait()
    }

    /// The particles after the last frame; waits for it.
    ///
    /// # Errors
    /// Memory and Vulkan errors.
    pub fn read(&mut self) -> Result<Vec<Particle>> {
        let [positions, velocities] = self.machine.read()?;
        let rows = positions.iter().zip(&velocities);
        let particle = |(p, v): (&[f32; 4], &[f32; 4])| Particle {
            position: Vec3::from_slice(p),
            radius: p[3],
            velocity: Vec3::from_slice(v),
            contacts: v[3] as u32,
        };
        Ok(rows.map(particle).collect())
    }

    /// Replaces all particles; waits for the last frame.
    ///
    /// # Errors
    /// [`Error::Argument`] for another number of particles, or naming one that is out of range; memory and Vulkan errors.
    pub fn write(&mut self, particles: &[Particle]) -> Result<()> {
        check(particles)?;
        if particles.len() != self.count as usize {
            let reason = format!("{} for {}", particles.len(), self.count);
            return Err(Error::argument("particles", reason));
        }
        let positions = particles.iter().map(|p| p.position.extend(p.radius));
        let velocities = particles
            .iter()
            .map(|p| p.velocity.extend(p.contacts as f32));
        let positions: Vec<[f32; 4]> = positions.map(Into::into).collect();
        let velocities: Vec<[f32; 4]> = velocities.map(Into::into).collect();
        self.machine.write([&positions, &velocities])
    }

    /// Number of particles.
    pub fn count(&self) -> u32 {
        self.count
    }

    /// Spheres, capsules and thick triangles of the shape, each of which is looked at for every flight of every particle.
    pub fn primitives(&self) -> usize {
        self.moving.primitives().len()
    }

    /// Spheres of the shape where it is, or goes to.
    pub fn balls(&self) -> &[Ball] {
        self.moving.balls()
    }

    /// The settings.
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    /// GPU times of the last completed frame, where timestamps are on; none on the CPU.
    pub fn timings(&self) -> Option<FrameTimings> {
        self.machine.timings()
    }

    /// CPU time that the last [`Particles::advance`] took to record and submit, nanoseconds.
    pub fn record_ns(&self) -> u64 {
        self.record_ns
    }

    /// Bytes by class and name: of all that is on the device, or of these particles on the CPU.
    pub fn memory(&self) -> MemoryReport {
        self.machine.memory()
    }
}

/// Rounds in which a particle's place on a moving solid is found; from one to the next it errs by a share of about the solid's turn.
const CARRIES: u32 = 2;

/// # Errors
/// [`Error::Argument`] naming the first particle that is out of range.
fn check(particles: &[Particle]) -> Result<()> {
    let large = |v: Vec3| v.is_nan() || v.abs().max_element() > GREATEST;
    let wrong = |p: &Particle| {
        large(p.position) || large(p.velocity) || !(0.0..=GREATEST).contains(&p.radius)
    };
    match particles.iter().position(wrong) {
        None => Ok(()),
        Some(row) => {
            let reason = "its position, velocity or radius is not finite or beyond 1e8, or the radius negative";
            Err(Error::argument(format!("particle {row}"), reason))
        }
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests;
