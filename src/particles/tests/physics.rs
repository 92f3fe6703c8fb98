//! What holds for bounces, on the CPU device, whose pass the GPU's is compared with.

use super::*;

/// Kinetic and potential energy of a unit of mass.
fn energy(particle: &Particle, gravity: Vec3) -> f64 {
    let (v, g) = (particle.velocity.as_dvec3(), gravity.as_dvec3());
    0.5 * v.length_squared() - g.dot(particle.position.as_dvec3())
}

#[test]
fn on_a_still_shape_energy_never_grows_and_nothing_gets_inside() {
    let shape = figure();
    for (speed, restitution, friction, gravity, seconds) in [
        (3.0, 1.0, 0.0, 9.81, 0.02),
        (3.0, 0.6, 0.3, 9.81, 0.02),
        (0.5, 0.0, 1.0, 30.0, 0.01),
        (300.0, 1.0, 0.0, 0.0, 1e-4),
    ] {
        let mut chance = Chance(7);
        let settings = Settings {
            gravity: Vec3::new(0.0, -gravity, 0.0),
            restitution,
            friction,
            contacts: 8,
        };
        let cloud = cloud(3000, speed, &mut chance);
        let mut particles = Particles::new(&Device::Cpu, &shape, &cloud, &settings).unwrap();
        let size = particles.moving.size() as f32;
        assert!(inside(&shape, &cloud, size).is_some());
        // The first frame pushes out what began inside, which may lift it.
        particles.advance(&shape.balls, seconds).unwrap();
        let mut before = particles.read().unwrap();
        outside(&shape, &before, size);
        let mut contacts = 0;
        for _ in 0..20 {
            particles.advance(&shape.balls, seconds).unwrap();
            let after = particles.read().unwrap();
            outside(&shape, &after, size);
            for (a, b) in before.iter().zip(&after) {
                let (was, is) = (energy(a, settings.gravity), energy(b, settings.gravity));
                // Rounding of places and speeds; a push back onto the surface, by a touch at most.
                let scale = b.velocity.length_squared() + gravity * (b.position.length() + 1.0);
                let lift = f64::from(gravity) * tolerance(size, b) * 4.0;
                let room = 4e-6 * f64::from(scale) + lift;
                assert!(is <= was + room, "{was} {is} {room}: {a:?} {b:?}");
                contacts += u64::from(b.contacts - a.contacts);
            }
            before = after;
        }
        assert!(contacts > 100, "{contacts}");
    }
}

#[test]
fn nothing_tunnels_through_however_fast() {
    let shape = figure();
    let collider = Collider::new(&shape).unwrap();
    let mut chance = Chance(11);
    let mut cloud = cloud(4000, 1.0, &mut chance);
    // From far outside through the middle of the body, a hundred times its size in a frame.
    for particle in &mut cloud {
        let from = chance.point(1.0).normalize() * 3.0;
        let through = chance.point(0.3);
        particle.position = from.as_vec3();
        particle.velocity = ((through - from) * 4000.0).as_vec3();
    }
    let settings = Settings {
        contacts: 1,
        ..still()
    };
    let mut particles = Particles::new(&Device::Cpu, &shape, &cloud, &settings).unwrap();
    particles.advance(&shape.balls, 1.0 / 60.0).unwrap();
    let (mut hits, mut grazed) = (0, 0);
    for (a, b) in cloud.iter().zip(particles.read().unwrap()) {
        let seconds = 1.0 / 60.0;
        let (from, way) = (a.position.as_dvec3(), a.velocity.as_dvec3() * seconds);
        // A path is straight to the last places of its length.
        let room = 1e-6 * way.length();
        let sweep = |more: f64| Sweep {
            from,
            to: from + way,
            radius: (f64::from(a.radius) + more).max(0.0),
        };
        let (thin, thick) = (
            collider.first(&sweep(-room)).is_some(),
            collider.first(&sweep(room)).is_some(),
        );
        let hit = b.contacts > 0;
        assert!(hit || !thin, "{a:?} {b:?}");
        assert!(!hit || thick, "{a:?} {b:?}");
        hits += usize::from(hit);
        grazed += usize::from(thin != thick);
    }
    assert!(hits > 1500 && grazed < 40, "{hits} {grazed}");
}

#[test]
fn what_hits_a_particle_takes_it_along_and_never_over_it() {
    let shape = with(&figure(), &posed(0.0));
    for step in [0.004, 0.02, 0.1] {
        let mut chance = Chance(13);
        let settings = Settings {
            contacts: 8,
            friction: 0.2,
            ..still()
        };
        let cloud = cloud(3000, 0.1, &mut chance);
        let mut particles = Particles::new(&Device::Cpu, &shape, &cloud, &settings).unwrap();
        for frame in 1..=15 {
            let balls = posed(f64::from(frame) * step);
            let size = particles.moving.size() as f32;
            particles.advance(&balls, 1.0 / 30.0).unwrap();
            let after = particles.read().unwrap();
            outside(
                &with(&shape, &balls),
                &after,
                size.max(particles.moving.size() as f32),
            );
        }
        let fastest = particles.read().unwrap().into_iter();
        let fastest = fastest.map(|p| p.velocity.length()).fold(0.0, f32::max);
        assert!(fastest > 0.2, "{fastest}");
    }
}

#[test]
fn a_wall_that_crosses_a_particle_in_one_frame_drives_it_before_itself() {
    // A thick triangle, far wider than it is thick, goes 2 across particles at rest.
    let wall = Shape {
        balls: vec![
            ball(0.0, -9.0, -9.0, 0.05),
            ball(0.0, 9.0, -9.0, 0.05),
            ball(0.0, 0.0, 9.0, 0.05),
        ],
        edges: Vec::new(),
        triangles: vec![[0, 1, 2]],
    };
    let mut gone = wall.clone();
    gone.balls.iter_mut().for_each(|b| b.centre.x += 2.0);
    let row = |k: usize| Particle {
        position: Vec3::new(0.2 + 0.01 * k as f32, 0.0, -1.0),
        radius: 0.05,
        ..Particle::default()
    };
    let cloud: Vec<Particle> = (0..150).map(row).collect();
    let mut particles = Particles::new(&Device::Cpu, &wall, &cloud, &still()).unwrap();
    particles.advance(&gone.balls, 0.5).unwrap();
    for (a, b) in cloud.iter().zip(particles.read().unwrap()) {
        // Met at speed 4 when the wall's face was there, it leaves at 8.
        let met = (a.position.x - 0.1) / 4.0;
        let wanted = a.position.x + 8.0 * (0.5 - met);
        assert_eq!(b.contacts, 1, "{b:?}");
        assert!((b.position.x - wanted).abs() < 1e-5, "{b:?} {wanted}");
        assert!((b.velocity - Vec3::X * 8.0).length() < 1e-4, "{b:?}");
    }
}

#[test]
fn bounces_keep_their_share_friction_slows_and_rest_is_rest() {
    let floor = Shape {
        balls: vec![
            ball(-50.0, -1.0, -50.0, 1.0),
            ball(50.0, -1.0, -50.0, 1.0),
            ball(0.0, -1.0, 50.0, 1.0),
        ],
        edges: Vec::new(),
        triangles: vec![[0, 1, 2]],
    };
    let settings = Settings {
        restitution: 0.5,
        friction: 0.25,
        ..Settings::default()
    };
    let drop = Particle {
        position: Vec3::new(0.0, 1.1, 0.0),
        radius: 0.1,
        ..Particle::default()
    };
    let slide = Particle {
        position: Vec3::new(1.0, 0.1, 0.0),
        velocity: Vec3::X * 2.0,
        ..drop
    };
    let point = Particle {
        radius: 0.0,
        ..drop
    };
    let cloud = [drop, slide, point];
    let mut particles = Particles::new(&Device::Cpu, &floor, &cloud, &settings).unwrap();
    let mut top = [0f32; 2];
    let seconds = 1.0 / 240.0;
    for step in 0..960 {
        particles.advance(&floor.balls, seconds).unwrap();
        let now = particles.read().unwrap();
        // After the first bounce.
        if now[0].contacts >= 1 && now[0].contacts < 2 {
            top[0] = top[0].max(now[0].position.y - 0.1);
        }
        if step == 47 {
            // Coulomb: it slows by μ g.
            let wanted = 2.0 - 0.25 * 9.81 * 0.2;
            assert!((now[1].velocity.x - wanted).abs() < 1e-3, "{:?}", now[1]);
        }
    }
    // A height of 1 becomes one of a quarter.
    assert!((top[0] - 0.25).abs() < 2e-3, "{top:?}");
    let end = particles.read().unwrap();
    for (particle, height) in end.iter().zip([0.1, 0.1, 0.0]) {
        assert!(particle.velocity.length() < 1e-4, "{particle:?}");
        assert!((particle.position.y - height).abs() < 1e-4, "{particle:?}");
    }
    let far = end[1].position.x - 1.0;
    assert!((far - 4.0 / (2.0 * 0.25 * 9.81)).abs() < 1e-2, "{far}");
}

#[test]
fn a_point_bounces_off_a_sheet_on_the_side_that_it_comes_from() {
    let sheet = Shape {
        balls: vec![
            ball(-1.0, 0.0, -1.0, 0.0),
            ball(1.0, 0.0, -1.0, 0.0),
            ball(0.0, 0.0, 2.0, 0.0),
        ],
        edges: Vec::new(),
        triangles: vec![[0, 1, 2]],
    };
    let cloud = [1.0, -1.0].map(|side: f32| Particle {
        position: Vec3::new(0.0, 0.5 * side, 0.0),
        velocity: Vec3::new(0.0, -side * 25.0, 0.0),
        ..Particle::default()
    });
    let mut particles = Particles::new(&Device::Cpu, &sheet, &cloud, &still()).unwrap();
    for _ in 0..3 {
        particles.advance(&sheet.balls, 1.0 / 60.0).unwrap();
    }
    for (a, b) in cloud.iter().zip(particles.read().unwrap()) {
        assert_eq!((b.contacts, b.velocity), (1, -a.velocity));
        assert!((b.position.y - 1.5 * a.position.y).abs() < 1e-5, "{b:?}");
    }
}

#[test]
fn what_is_out_of_range_is_named_and_changes_nothing() {
    let shape = figure();
    let cloud = [Particle::default(); 2];
    let new = |cloud: &[Particle], settings: &Settings| {
        let made = Particles::new(&Device::Cpu, &shape, cloud, settings);
        made.map(|_| ()).unwrap_err().to_string()
    };
    let settings = Settings::default();
    assert!(new(&[], &settings).contains("particles"));
    let mut bad = cloud;
    bad[1].velocity.y = f32::NAN;
    assert!(new(&bad, &settings).contains("particle 1"));
    bad = cloud;
    bad[0].radius = -1.0;
    assert!(new(&bad, &settings).contains("particle 0"));
    for (settings, named) in [
        (
            Settings {
                restitution: 1.5,
                ..settings
            },
            "restitution",
        ),
        (
            Settings {
                friction: f32::NAN,
                ..settings
            },
            "friction",
        ),
        (
            Settings {
                gravity: Vec3::NAN,
                ..settings
            },
            "gravity",
        ),
        (
            Settings {
                contacts: 0,
                ..settings
            },
            "contacts",
        ),
    ] {
        assert!(new(&cloud, &settings).contains(named), "{named}");
    }
    let mut particles = Particles::new(&Device::Cpu, &shape, &cloud, &settings).unwrap();
    let before = particles.read().unwrap();
    let mut refused = |balls: &[Ball], seconds: f32, named: &str| {
        let error = particles.advance(balls, seconds).unwrap_err().to_string();
        assert!(error.contains(named), "{error}");
        assert_eq!(particles.read().unwrap(), before);
        assert_eq!(particles.balls(), shape.balls);
    };
    refused(&shape.balls, 0.0, "seconds");
    refused(&shape.balls, f32::NAN, "seconds");
    refused(&shape.balls[1..], 0.1, "spheres");
    let mut far = shape.balls.clone();
    far[3].centre.x = 1e9;
    refused(&far, 0.1, "sphere 3");
    assert!(particles.write(&before[1..]).is_err());
}
