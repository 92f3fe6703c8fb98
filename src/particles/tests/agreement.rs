//! The pass on a validated device against its twin and against the collider in double precision.

use super::*;

/// Where and how fast particles are after a frame in which the figure moves.
fn after(device: &Device, cloud: &[Particle], settings: &Settings) -> Vec<Particle> {
    let shape = with(&figure(), &posed(0.0));
    let mut particles = Particles::new(device, &shape, cloud, settings).unwrap();
    particles.advance(&posed(0.03), 1.0 / 30.0).unwrap();
    particles.read().unwrap()
}

/// How far two outcomes are apart: places, and speeds over a frame.
fn apart(a: &Particle, b: &Particle) -> f32 {
    let speed = (a.velocity - b.velocity).length() / 30.0;
    a.position.distance(b.position).max(speed)
}

/// Rounding of places of size 2 and of paths as long, grown by up to eight bounces off spheres.
const ROUNDING: f32 = 2e-4;

/// Rows that differ, but for those whose outcome hangs on the last places of their start; and the number of these.
fn differences(device: &[Particle], cloud: &[Particle], settings: &Settings) -> (usize, usize) {
    let twin = after(&Device::Cpu, cloud, settings);
    let mut forks = vec![false; cloud.len()];
    for way in [Vec3::X, Vec3::Y, Vec3::Z] {
        for side in [-1.0, 1.0] {
            let mut near = cloud.to_vec();
            let shift = 4.0 * f32::EPSILON * side * way;
            near.iter_mut().for_each(|p| p.position += shift);
            let other = after(&Device::Cpu, &near, settings);
            let rows = forks.iter_mut().zip(twin.iter().zip(&other));
            rows.for_each(|(fork, (a, b))| {
                *fork |= apart(a, b) > 0.2 * ROUNDING || a.contacts != b.contacts;
            });
        }
    }
    let wrong = |k: &usize| {
        let differs = device[*k].contacts != twin[*k].contacts;
        !forks[*k] && (differs || apart(&device[*k], &twin[*k]) > ROUNDING)
    };
    let wrong = (0..cloud.len()).filter(wrong).count();
    (wrong, forks.iter().filter(|f| **f).count())
}

#[test]
fn the_device_agrees_with_the_twin() {
    let Some(gpu) = testing::gpu() else { return };
    let device = Device::Gpu(gpu.clone());
    for (speed, contacts) in [(3.0, 4), (60.0, 8), (0.2, 1)] {
        let settings = Settings {
            contacts,
            ..Settings::default()
        };
        let cloud = cloud(5000, speed, &mut Chance(3));
        let on_device = after(&device, &cloud, &settings);
        let (wrong, forks) = differences(&on_device, &cloud, &settings);
        println!(
            "speed {speed}: {forks} of {} hang on their last places",
            cloud.len()
        );
        assert!(wrong == 0 && forks < cloud.len() / 20, "{wrong} {forks}");
        let touched = on_device.iter().filter(|p| p.contacts > 0).count();
        println!("{touched} touch");
        assert!(touched > 100, "{touched}");
        // What is not the same is told.
        let other = Settings {
            restitution: settings.restitution + 0.01,
            ..settings
        };
        let (wrong, _) = differences(&after(&device, &cloud, &other), &cloud, &settings);
        assert!(wrong > 50, "{wrong}");
    }
}

#[test]
fn on_a_device_nothing_gets_inside_and_bits_are_the_same_again() {
    let Some(gpu) = testing::gpu() else { return };
    let device = Device::Gpu(gpu.clone());
    let shape = with(&figure(), &posed(0.0));
    let cloud = cloud(3000, 20.0, &mut Chance(5));
    let run = || {
        let mut particles = Particles::new(&device, &shape, &cloud, &Settings::default()).unwrap();
        let mut bits = Vec::new();
        for frame in 1..=12 {
            let balls = posed(0.02 * f64::from(frame));
            let size = particles.moving.size().max(2.5) as f32;
            particles.advance(&balls, 1.0 / 30.0).unwrap();
            let after = particles.read().unwrap();
            outside(&with(&shape, &balls), &after, size);
            bits.extend(after);
        }
        // Frames that are not waited for, in flight together.
        for frame in 13..=20 {
            let balls = posed(0.02 * f64::from(frame));
            particles.advance(&balls, 1.0 / 30.0).unwrap();
        }
        bits.extend(particles.read().unwrap());
        bits
    };
    assert!(run() == run());
    assert_eq!(gpu.memory().total, 0);
}

#[test]
fn single_precision_touches_where_double_does() {
    let Some(gpu) = testing::gpu() else { return };
    let shape = figure();
    let collider = Collider::new(&shape).unwrap();
    let mut chance = Chance(17);
    let settings = Settings {
        contacts: 1,
        ..still()
    };
    // Segments from outside, through the box.
    let mut cloud = cloud(20_000, 1.0, &mut chance);
    for particle in &mut cloud {
        let from = chance.point(1.0).normalize() * 2.0;
        particle.position = from.as_vec3();
        particle.velocity = (chance.point(0.8) - from).as_vec3() * 2.0;
    }
    let mut particles =
        Particles::new(&Device::Gpu(gpu.clone()), &shape, &cloud, &settings).unwrap();
    particles.advance(&shape.balls, 1.0).unwrap();
    let (mut worst, mut other, mut hits) = (0f64, 0, 0);
    for (a, b) in cloud.iter().zip(particles.read().unwrap()) {
        let from = a.position.as_dvec3();
        let sweep = Sweep {
            from,
            to: from + a.velocity.as_dvec3(),
            radius: f64::from(a.radius),
        };
        match collider.first(&sweep) {
            Some(hit) if b.contacts == 1 => {
                // Grazing, a place along the path is worth less than one across it.
                let way = a.velocity.as_dvec3().normalize();
                let against = -way.dot(hit.normal);
                let error = hit.position.distance(b.position.as_dvec3());
                worst = worst.max(error * against);
                hits += 1;
            }
            None if b.contacts == 0 => {}
            _ => other += 1,
        }
    }
    println!("{hits} touch, {other} differ in whether they do; error {worst:e} across");
    assert!(
        hits > 5000 && other <= 4 && worst < 5e-6,
        "{hits} {other} {worst}"
    );
}
