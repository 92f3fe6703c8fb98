mod agreement;
mod physics;

use glam::{DQuat, DVec3, Vec3};

use super::*;
use crate::{
    gpu::testing,
    sphere_mesh::{Collider, Sweep, testing::Chance},
};

fn ball(x: f64, y: f64, z: f64, radius: f64) -> Ball {
    Ball {
        centre: DVec3::new(x, y, z),
        radius,
    }
}

/// A body of thick triangles with limbs, a lone sphere, a sheet and degenerate solids; a little under 2 wide.
fn figure() -> Shape {
    let balls = vec![
        ball(-0.4, 0.1, 0.0, 0.2),
        ball(-0.1, -0.1, 0.1, 0.25),
        ball(0.1, 0.15, -0.05, 0.15),
        ball(0.4, -0.05, 0.0, 0.2),
        ball(-0.5, -0.5, 0.1, 0.05),
        ball(-0.55, -0.8, 0.1, 0.08),
        ball(0.55, -0.6, -0.1, 0.03),
        ball(0.0, 0.7, 0.0, 0.1),
        ball(0.6, 0.5, 0.3, 0.01),
        ball(0.9, 0.6, -0.1, 0.01),
        ball(0.7, 0.9, 0.1, 0.02),
        // Within the first; on its own.
        ball(-0.42, 0.12, 0.0, 0.1),
        ball(-0.7, 0.6, -0.5, 0.12),
    ];
    Shape {
        balls,
        edges: vec![[0, 4], [4, 5], [3, 6], [2, 7], [0, 11]],
        triangles: vec![[0, 1, 2], [1, 2, 3], [8, 9, 10], [2, 3, 8]],
    }
}

/// The figure's spheres, turned about an axis through the origin and bent, with `time`.
fn posed(time: f64) -> Vec<Ball> {
    let turn = DQuat::from_axis_angle(DVec3::new(0.3, 1.0, 0.2).normalize(), 3.0 * time);
    let mut balls = figure().balls;
    for (k, ball) in balls.iter_mut().enumerate() {
        let sway = 0.1 * (7.0 * time + k as f64).sin();
        ball.centre = turn * (ball.centre + DVec3::new(0.0, sway, 0.5 * sway)) + DVec3::X * time;
    }
    balls
}

/// Around and in the figure, with speeds up to `speed`.
fn cloud(count: usize, speed: f64, chance: &mut Chance) -> Vec<Particle> {
    let particle = |_| Particle {
        position: chance.point(0.9).as_vec3(),
        radius: (0.002 + 0.03 * chance.next()) as f32,
        velocity: chance.point(speed).as_vec3(),
        contacts: 0,
    };
    (0..count).map(particle).collect()
}

/// How deep the particle may be inside, by what [`Particles`] says of it: what counts as touching, and rounding.
fn tolerance(size: f32, particle: &Particle) -> f64 {
    let far = particle.position.abs().max_element();
    f64::from(5e-6 * (size + particle.radius + far))
}

/// The first particle that is inside of the shape by more than it may be.
fn inside(shape: &Shape, particles: &[Particle], size: f32) -> Option<usize> {
    let collider = Collider::new(shape).unwrap();
    particles.iter().position(|particle| {
        let at = particle.position.as_dvec3();
        let radius = f64::from(particle.radius) - tolerance(size, particle);
        let sweep = Sweep {
            from: at,
            to: at,
            radius: radius.max(0.0),
        };
        collider.first(&sweep).is_some_and(|hit| hit.pushed)
    })
}

#[track_caller]
fn outside(shape: &Shape, particles: &[Particle], size: f32) {
    if let Some(row) = inside(shape, particles, size) {
        panic!("particle {row} is inside: {:?}", particles[row]);
    }
}

/// A shape with spheres elsewhere.
fn with(shape: &Shape, balls: &[Ball]) -> Shape {
    Shape {
        balls: balls.to_vec(),
        ..shape.clone()
    }
}

fn still() -> Settings {
    Settings {
        gravity: Vec3::ZERO,
        restitution: 1.0,
        friction: 0.0,
        contacts: 8,
    }
}
