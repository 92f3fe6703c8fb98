//! A shower of particles over an animated level: where they begin, and where they begin again.

use dermis::{
    Result,
    deformer::Device,
    particles::{Particle, Particles, Settings},
    sphere_mesh::{Hierarchy, Level, Shape},
};
use glam::{Quat, Vec3};

/// How a level goes on in time, stood up.
pub(super) struct Stage<'a> {
    pub(super) hierarchy: &'a Hierarchy,
    pub(super) level: &'a Level,
    pub(super) upright: Quat,
    /// Frames of the sequence a second.
    pub(super) fps: f64,
    /// Begin again behind the last frame; else it stays.
    pub(super) again: bool,
}

impl Stage<'_> {
    /// The level after some seconds. From the last frame to the first it goes in the time of a frame.
    pub(super) fn at(&self, seconds: f64) -> Shape {
        let frames = self.hierarchy.frames as f64;
        let time = seconds * self.fps;
        let time = if self.again { time % frames } else { time };
        let mut shape = Shape::at(self.hierarchy, self.level, time);
        let back = (time - (frames - 1.0)).max(0.0);
        if self.again && back > 0.0 {
            let first = Shape::at(self.hierarchy, self.level, 0.0);
            for (ball, first) in shape.balls.iter_mut().zip(&first.balls) {
                ball.centre = ball.centre.lerp(first.centre, back);
            }
        }
        let upright = self.upright.as_dquat();
        for ball in &mut shape.balls {
            ball.centre = upright * ball.centre;
        }
        shape
    }
}

/// Numbers from 0 to 1, the same for the same seed.
struct Chance(u64);

impl Chance {
    fn next(&mut self) -> f32 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 40) as f32 / (1u64 << 24) as f32
    }
}

/// What falls, and how.
#[derive(Clone, Copy)]
pub(super) struct Weather {
    pub(super) count: usize,
    pub(super) radius: f32,
    pub(super) settings: Settings,
    pub(super) seed: u64,
}

/// Particles that fall through a column around the level, and again from its top when they have left it.
pub(super) struct Shower {
    pub(super) particles: Particles,
    /// The last read.
    pub(super) rows: Vec<Particle>,
    chance: Chance,
    /// Seconds so far, and those before which each may not begin again.
    clock: f32,
    waits: Vec<f32>,
    /// Corners of the column.
    low: Vec3,
    high: Vec3,
    gravity: f32,
    speed: f32,
    /// Contacts of those that have begun again.
    before: u64,
}

impl Shower {
    /// Over all that the level covers in these shapes.
    pub(super) fn new(device: &Device, shapes: &[Shape], weather: &Weather) -> Result<Self> {
        let ends = |side: f32| {
            let balls = shapes.iter().flat_map(|s| &s.balls);
            balls.map(move |b| b.centre.as_vec3() + side * b.radius as f32)
        };
        let low = ends(-1.0).reduce(Vec3::min).unwrap_or_default();
        let high = ends(1.0).reduce(Vec3::max).unwrap_or_default();
        let size = (high - low).length();
        let gravity = weather.settings.gravity.length();
        let room = Vec3::new(0.1, 0.15, 0.1) * size + weather.radius;
        let mut shower = Self {
            particles: Particles::new(
                device,
                &shapes[0],
                &vec![Particle::default(); weather.count],
                &weather.settings,
            )?,
            rows: Vec::new(),
            chance: Chance(weather.seed),
            clock: 0.0,
            waits: vec![0.0; weather.count],
            low: low - room,
            high: high + room + Vec3::Y * 0.6 * size,
            gravity,
            speed: 0.4 * size,
            before: 0,
        };
        shower.start(high.y + weather.radius, weather)?;
        Ok(shower)
    }

    /// As if it had rained for long, but for where the level may be: particles are on their way down to `clear`, others begin in
    /// turn. As many pass a height at any time.
    fn start(&mut self, clear: f32, weather: &Weather) -> Result<()> {
        let (above, all) = (
            self.fall(self.high.y - clear),
            self.fall(self.high.y - self.low.y),
        );
        for row in 0..weather.count {
            let mut particle = self.begin(weather.radius);
            let late = above - all * self.chance.next();
            if late > 0.0 {
                self.delay(&mut particle, late);
            } else {
                // Out of the way.
                particle.position.y = self.low.y - (self.high.y - self.low.y);
                self.waits[row] = -late;
            }
            self.rows.push(particle);
        }
        self.particles.write(&self.rows)
    }

    /// Seconds from the top to so far below.
    fn fall(&self, way: f32) -> f32 {
        let (v, g) = (self.speed, self.gravity);
        // The root of g t² / 2 + v t = way that also is one without gravity.
        2.0 * way / (v + (v * v + 2.0 * g * way).sqrt())
    }

    /// A particle some seconds after its beginning.
    fn delay(&self, particle: &mut Particle, seconds: f32) {
        particle.position.y -= (self.speed + 0.5 * self.gravity * seconds) * seconds;
        particle.velocity.y -= self.gravity * seconds;
    }

    /// A particle at the top.
    fn begin(&mut self, radius: f32) -> Particle {
        let share = Vec3::new(self.chance.next(), 1.0, self.chance.next());
        Particle {
            position: self.low + (self.high - self.low) * share,
            radius,
            velocity: Vec3::new(0.0, -self.speed, 0.0),
            contacts: 0,
        }
    }

    /// One step.
    pub(super) fn advance(&mut self, shape: &Shape, seconds: f32) -> Result<()> {
        self.particles.advance(&shape.balls, seconds)
    }

    /// Reads all particles, and has those that have fallen out of the column begin again.
    pub(super) fn renew(&mut self, seconds: f32) -> Result<()> {
        self.rows = self.particles.read()?;
        self.clock += seconds;
        let mut again = false;
        for row in 0..self.rows.len() {
            let Particle {
                position,
                radius,
                contacts,
                ..
            } = self.rows[row];
            if position.y < self.low.y && self.waits[row] <= self.clock {
                self.before += u64::from(contacts);
                let mut particle = self.begin(radius);
                // Somewhere on the way that it goes until the next look, so that they come in no rows.
                let late = self.chance.next() * seconds;
                self.delay(&mut particle, late);
                self.rows[row] = particle;
                again = true;
            }
        }
        if again {
            self.particles.write(&self.rows)?;
        }
        Ok(())
    }

    /// Contacts of all so far.
    pub(super) fn contacts(&self) -> u64 {
        let now = self.rows.iter().map(|p| u64::from(p.contacts));
        self.before + now.sum::<u64>()
    }
}
