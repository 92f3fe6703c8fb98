//! Moving spheres against sphere-meshes: tests of a sweep against a primitive a second, on one core and on all; particles on a
//! device, and how far its single precision is from the library's double.
//!
//! `cargo bench --bench collide -- [X.dsm N]`: with a file its level of N spheres; without, a figure of the bench's own.
#![allow(missing_docs)]

use std::{error::Error, hint::black_box, path::Path, time::Instant};

use dermis::{
    deformer::Device,
    gpu::{Gpu, GpuOptions, Profile},
    particles::{Particle, Particles, Settings},
    sphere_mesh::{Ball, Collider, Hierarchy, Shape, Sweep},
};
use glam::{DVec3, Vec3};

/// Each figure is the best of this many.
const TRIES: usize = 30;
const SWEEPS: usize = 20_000;
/// Particles on a device.
const PARTICLES: usize = 100_000;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args()
        .skip(1)
        .filter(|a| !a.starts_with('-'))
        .collect();
    println!(
        "million tests of a sweep against a primitive a second, best of {TRIES}; {} threads in parallel",
        rayon::current_num_threads()
    );
    let all = match &arguments[..] {
        [file, spheres] => {
            let hierarchy = Hierarchy::load(Path::new(file))?;
            let level = hierarchy.level(spheres.parse()?)?.optimised(&hierarchy);
            Shape::new(&hierarchy, &level, 0)
        }
        _ => figure(),
    };
    let (low, high) = bounds(&all);
    let size = (high - low).length();
    let mut chance = Chance(1);
    let crossing = sweeps(
        |_| (chance.between(low, high), chance.between(low, high)),
        size,
    );
    let mut chance = Chance(2);
    let around = 0.02 * size;
    let short = sweeps(
        |_| {
            let from = chance.between(low, high);
            (
                from,
                from + chance.between(-DVec3::ONE, DVec3::ONE) * around,
            )
        },
        size,
    );
    measure("whole, across the box", &all, &crossing)?;
    measure("whole, particles' steps", &all, &short)?;
    particles(&all)?;
    // Aimed at the middle of a single primitive, so that no bound spares the exact forms.
    for (name, count) in [("sphere", 1), ("capsule", 2), ("thick triangle", 3)] {
        let corners = [
            (DVec3::ZERO, 0.2),
            (DVec3::X, 0.1),
            (DVec3::new(0.3, 0.9, 0.1), 0.15),
        ];
        let balls: Vec<Ball> = corners[..count]
            .iter()
            .map(|&(centre, radius)| Ball { centre, radius })
            .collect();
        let middle = balls.iter().map(|b| b.centre).sum::<DVec3>() / count as f64;
        let edges = if count == 2 { vec![[0, 1]] } else { vec![] };
        let triangles = if count == 3 { vec![[0, 1, 2]] } else { vec![] };
        let shape = Shape {
            balls,
            edges,
            triangles,
        };
        let mut chance = Chance(3);
        let aimed = sweeps(
            |_| {
                let out = chance
                    .between(-DVec3::ONE, DVec3::ONE)
                    .normalize_or(DVec3::X)
                    * 3.0;
                let past = chance.between(-DVec3::ONE, DVec3::ONE) * 0.5;
                (middle + out, middle - out + past)
            },
            1.0,
        );
        measure(&format!("one {name}, aimed at it"), &shape, &aimed)?;
    }
    Ok(())
}

/// As many particles on the best device, each of which flies until its first contact.
fn particles(shape: &Shape) -> Result<(), Box<dyn Error>> {
    let options = GpuOptions {
        profile: Profile::Full,
        ..GpuOptions::default()
    };
    let gpu = Gpu::new(&options)?;
    println!("{PARTICLES} particles on {}:", gpu.report().name);
    let (low, high) = bounds(shape);
    let size = (high - low).length();
    for (name, reach) in [
        ("across the box", None),
        ("particles' steps", Some(0.02 * size)),
    ] {
        let mut chance = Chance(5);
        let cloud: Vec<Particle> = (0..PARTICLES)
            .map(|_| {
                let from = chance.between(low, high);
                let to = match reach {
                    None => chance.between(low, high),
                    Some(reach) => from + chance.between(-DVec3::ONE, DVec3::ONE) * reach,
                };
                Particle {
                    position: from.as_vec3(),
                    radius: (0.005 * size) as f32,
                    velocity: (to - from).as_vec3(),
                    contacts: 0,
                }
            })
            .collect();
        let settings = Settings {
            gravity: Vec3::ZERO,
            restitution: 1.0,
            friction: 0.0,
            contacts: 1,
        };
        let mut particles = Particles::new(&Device::Gpu(gpu.clone()), shape, &cloud, &settings)?;
        let mut best = f64::INFINITY;
        for _ in 0..TRIES {
            particles.write(&cloud)?;
            particles.advance(&shape.balls, 1.0)?;
            particles.wait()?;
            let pass = particles.timings();
            let ns = pass.map(|t| t.by_name().iter().find(|p| p.0 == "particles").map(|p| p.2));
            best = best.min(ns.flatten().unwrap_or(u64::MAX) as f64);
        }
        let tests = (PARTICLES * particles.primitives()) as f64;
        println!(
            "  {name}: {:.2} ms, {:.0} million tests a second, the looks for what is inside at the end included",
            1e-6 * best,
            1e3 * tests / best,
        );
        accuracy(shape, &cloud, &particles.read()?, size)?;
    }
    Ok(())
}

/// How far places of first contact are from those in double precision.
fn accuracy(
    shape: &Shape,
    before: &[Particle],
    after: &[Particle],
    size: f64,
) -> Result<(), Box<dyn Error>> {
    let collider = Collider::new(shape)?;
    let (mut errors, mut across) = (Vec::new(), 0f64);
    let (mut other, mut inside) = (0, 0);
    for (a, b) in before.iter().zip(after) {
        let (from, way) = (a.position.as_dvec3(), a.velocity.as_dvec3());
        let sweep = Sweep {
            from,
            to: from + way,
            radius: f64::from(a.radius),
        };
        match collider.first(&sweep) {
            // These are pushed out when they have flown.
            Some(hit) if hit.pushed => inside += 1,
            Some(hit) if b.contacts == 1 => {
                let error = hit.position - b.position.as_dvec3();
                errors.push(error.length());
                across = across.max(error.dot(hit.normal).abs());
            }
            None if b.contacts == 0 => {}
            _ => other += 1,
        }
    }
    errors.sort_by(f64::total_cmp);
    let part = |share: f64| {
        errors
            .get((share * errors.len() as f64) as usize)
            .map_or(0.0, |e| e / size)
    };
    println!(
        "  of {} segments {inside} begin inside, {} touch, {other} differ in whether they do; in sizes of the shape the place errs by {:.1e} (median), {:.1e} (99 %), {:.1e} (99.9 %) and along the normal by {:.1e} at most",
        before.len(),
        errors.len(),
        part(0.5),
        part(0.99),
        part(0.999),
        across / size,
    );
    Ok(())
}

fn sweeps(mut ends: impl FnMut(usize) -> (DVec3, DVec3), size: f64) -> Vec<Sweep> {
    (0..SWEEPS)
        .map(|k| {
            let (from, to) = ends(k);
            let radius = 0.005 * size;
            Sweep { from, to, radius }
        })
        .collect()
}

fn measure(name: &str, shape: &Shape, sweeps: &[Sweep]) -> Result<(), Box<dyn Error>> {
    let collider = Collider::new(shape)?;
    let (mut one, mut all, mut hits, mut pushed) = (f64::INFINITY, f64::INFINITY, 0, 0);
    for _ in 0..TRIES {
        let begin = Instant::now();
        for sweep in sweeps {
            black_box(collider.first(black_box(sweep)));
        }
        one = one.min(begin.elapsed().as_secs_f64());
        let begin = Instant::now();
        let found = collider.first_of_each(sweeps)?;
        all = all.min(begin.elapsed().as_secs_f64());
        hits = found.iter().flatten().count();
        pushed = found.iter().flatten().filter(|h| h.pushed).count();
    }
    let tests = 1e-6 * (sweeps.len() * collider.primitives()) as f64;
    let share = |n: usize| 100.0 * n as f64 / sweeps.len() as f64;
    println!(
        "{name}: {} primitives, {:.0} % hit, {:.0} % of all inside: {:.1} on one core, {:.1} in parallel",
        collider.primitives(),
        share(hits),
        share(pushed),
        tests / one,
        tests / all
    );
    Ok(())
}

/// A trunk of triangles with four chains of spheres on it: 46 spheres.
fn figure() -> Shape {
    let mut shape = Shape::default();
    for ring in 0..7 {
        for corner in 0..2 {
            let side = f64::from(2 * corner - 1);
            shape.balls.push(Ball {
                centre: DVec3::new(
                    f64::from(ring) / 6.0,
                    0.1 * side,
                    0.02 * f64::from(ring % 3),
                ),
                radius: 0.1 + 0.02 * f64::from(ring % 2),
            });
        }
    }
    for k in 0..12 {
        shape.triangles.push([k, k + 1, k + 2]);
    }
    for (leg, root) in [0u32, 1, 12, 13].into_iter().enumerate() {
        let mut last = root;
        let top = shape.balls[root as usize].centre;
        for joint in 1..=8 {
            let down = f64::from(joint) * 0.09;
            let sway = 0.03 * (f64::from(joint) + leg as f64).sin();
            shape.balls.push(Ball {
                centre: top + DVec3::new(sway, 0.0, -down),
                radius: 0.06 - 0.005 * f64::from(joint),
            });
            let row = shape.balls.len() as u32 - 1;
            shape.edges.push([last, row]);
            last = row;
        }
    }
    shape
}

fn bounds(shape: &Shape) -> (DVec3, DVec3) {
    let none = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    shape.balls.iter().fold(none, |(low, high), b| {
        (low.min(b.centre - b.radius), high.max(b.centre + b.radius))
    })
}

struct Chance(u64);

impl Chance {
    fn next(&mut self) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1);
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }

    fn between(&mut self, low: DVec3, high: DVec3) -> DVec3 {
        let share = DVec3::new(self.next(), self.next(), self.next());
        low + (high - low) * share
    }
}
