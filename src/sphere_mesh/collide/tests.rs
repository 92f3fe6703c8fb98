#![allow(clippy::unwrap_used)]

use super::{
    super::{shape::Solid, testing::Chance},
    *,
};

fn ball(centre: DVec3, radius: f64) -> Ball {
    Ball { centre, radius }
}

/// A handful of spheres, wires and triangles, degenerate ones among them.
fn shape(chance: &mut Chance) -> Shape {
    let mut balls: Vec<Ball> = (0..9)
        .map(|_| ball(chance.point(1.0), 0.3 * chance.next().powi(2)))
        .collect();
    // Coincident; one inside another; just barely not; collinear; no radius at all.
    balls.push(balls[0]);
    balls.push(ball(balls[1].centre + 0.01, balls[1].radius + 0.1));
    let gap = balls[2].radius * 0.75;
    balls.push(ball(
        balls[2].centre + DVec3::X * (gap * (1.0 + 1e-6)),
        balls[2].radius - gap,
    ));
    balls.push(ball((balls[3].centre + balls[4].centre) * 0.5, 0.25));
    balls.extend([DVec3::X, DVec3::Y, DVec3::Z].map(|p| ball(p + chance.point(0.5), 0.0)));
    Shape {
        edges: vec![[0, 9], [1, 10], [2, 11], [4, 5], [13, 14]],
        triangles: vec![[5, 6, 7], [3, 4, 12], [0, 1, 10], [13, 14, 15], [0, 9, 6]],
        balls,
    }
}

/// The least of a convex function over [0, end], and where.
fn least(end: f64, f: impl Fn(f64) -> f64) -> (f64, f64) {
    let (mut a, mut b) = (0.0, end);
    let ratio = 0.5 * (5f64.sqrt() - 1.0);
    let (mut x, mut y) = (b - ratio * (b - a), a + ratio * (b - a));
    let (mut fx, mut fy) = (f(x), f(y));
    for _ in 0..45 {
        if fx < fy {
            (b, y, fy) = (y, x, fx);
            x = b - ratio * (b - a);
            fx = f(x);
        } else {
            (a, x, fx) = (x, y, fy);
            y = a + ratio * (b - a);
            fy = f(y);
        }
    }
    [0.0, x, y, end]
        .map(|t| (f(t), t))
        .into_iter()
        .fold((f64::INFINITY, 0.0), |a, b| if b.0 < a.0 { b } else { a })
}

/// Signed distance of a sphere to the nearest surface.
fn clearance(solids: &[Solid], p: DVec3, radius: f64) -> f64 {
    let all = solids.iter().map(|s| s.distance(p) - radius);
    all.fold(f64::INFINITY, f64::min)
}

/// What a sweep's answer says, against signed distances at many places along it. The deepest that a free sphere comes.
fn judge(solids: &[Solid], sweep: &Sweep, hit: Option<&Hit>) -> f64 {
    let at = |t: f64| sweep.from + (sweep.to - sweep.from) * t;
    let inside = clearance(solids, sweep.from, sweep.radius) < -1e-8;
    let fail = |what: &str| panic!("{what}: {sweep:?} {hit:?} {solids:?}");
    if let Some(hit) = hit {
        let clear = clearance(solids, hit.position, sweep.radius);
        if hit.pushed != inside || clear.abs() > 1e-8 {
            fail(&format!("not on the surface by {clear}"));
        }
        if (hit.normal.length() - 1.0).abs() > 1e-9 {
            fail("normal");
        }
        // Outwards: the surface falls back along the normal.
        let out = clearance(solids, hit.position + hit.normal * 1e-4, sweep.radius);
        let radius = sweep.radius
            + solids
                .iter()
                .map(|s| s.nearest(hit.position).radius)
                .fold(0.0, f64::max);
        if radius > 0.01 && out < 0.5e-4 && solids.len() == 1 {
            fail("the normal points in");
        }
    }
    if inside {
        if hit.is_none() {
            fail("not pushed");
        }
        return 0.0;
    }
    let end = hit.map_or(1.0, |hit| hit.time);
    let mut deepest = 0f64;
    for solid in solids {
        let depth = |t: f64| solid.distance(at(t)) - sweep.radius;
        // Dense samples, and the exact minimum between them.
        let dense = (0..=32).map(|k| depth(end * f64::from(k) / 32.0));
        let (sharp, _) = least(end, depth);
        deepest = deepest.max(-dense.fold(sharp, f64::min));
    }
    if let Some(hit) = hit
        && !hit.pushed
        && at(hit.time).distance(hit.position) > 1e-12
    {
        fail("off the segment");
    }
    deepest
}

#[test]
fn random_segments_agree_with_dense_samples() {
    let mut chance = Chance(1);
    let (mut deepest, mut hits, mut pushed) = (0f64, 0, 0);
    for _ in 0..200 {
        let shape = shape(&mut chance);
        let collider = Collider::new(&shape).unwrap();
        let solids = shape.solids();
        let sweeps: Vec<Sweep> = (0..500)
            .map(|k| {
                let from = chance.point(1.5);
                let to = match k % 4 {
                    0 => chance.point(1.5),
                    1 => from + chance.point(0.05),
                    2 => from + chance.point(100.0),
                    _ => shape.balls[k % shape.balls.len()].centre,
                };
                let radius = [0.0, 0.001, 0.05, 0.3][k / 4 % 4];
                Sweep { from, to, radius }
            })
            .collect();
        for (sweep, hit) in sweeps.iter().zip(collider.first_of_each(&sweeps).unwrap()) {
            deepest = deepest.max(judge(&solids, sweep, hit.as_ref()));
            hits += usize::from(hit.is_some());
            pushed += usize::from(hit.is_some_and(|h| h.pushed));
        }
    }
    assert!(deepest < 1e-8, "{deepest}");
    assert!(hits > 30_000 && pushed > 3000, "{hits} {pushed}");
    eprintln!("deepest {deepest}, {hits} hits, {pushed} pushed");
}

/// A shape of one primitive.
fn single(solid: &Solid) -> Shape {
    let balls = solid.balls().to_vec();
    let (mut edges, mut triangles) = (vec![], vec![]);
    match balls.len() {
        2 => edges.push([0, 1]),
        3 => triangles.push([0, 1, 2]),
        _ => {}
    }
    Shape {
        balls,
        edges,
        triangles,
    }
}

/// The plane through the touching point holds the whole primitive behind it, as the support of convex solids wants, and a
/// sphere inside is pushed as far as it is deep.
#[test]
fn normals_support_the_primitive_and_pushes_are_as_long_as_the_depth() {
    let mut chance = Chance(7);
    let mut pushed = 0;
    for _ in 0..60 {
        for solid in shape(&mut chance).solids() {
            let collider = Collider::new(&single(&solid)).unwrap();
            let inner = |chance: &mut Chance| {
                let balls = solid.balls();
                let ball = balls[(chance.next() * balls.len() as f64) as usize];
                ball.centre + chance.point(0.7 * ball.radius)
            };
            for k in 0..20 {
                let from = match k % 2 {
                    0 => chance.point(2.0),
                    _ => inner(&mut chance),
                };
                let sweep = Sweep {
                    from,
                    to: inner(&mut chance),
                    radius: 0.1 * chance.next(),
                };
                let Some(hit) = collider.first(&sweep) else {
                    // Its way may end short of the surface only where it starts inside a ball without a radius.
                    assert!(solid.distance(sweep.to) - sweep.radius > -1e-8);
                    continue;
                };
                let touched = hit.point(sweep.radius);
                for ball in solid.balls() {
                    let support = (ball.centre - touched).dot(hit.normal) + ball.radius;
                    assert!(support < 1e-8, "{support} {solid:?} {sweep:?} {hit:?}");
                }
                if hit.pushed {
                    pushed += 1;
                    let depth = sweep.radius - solid.distance(from);
                    let way = hit.position.distance(from);
                    assert!(
                        (way - depth).abs() < 1e-8,
                        "{way} {depth} {solid:?} {sweep:?}"
                    );
                }
            }
        }
    }
    assert!(pushed > 1000, "{pushed}");
}

#[test]
fn what_bounces_is_free() {
    let mut chance = Chance(3);
    let mut bounced = 0;
    for _ in 0..20 {
        let shape = shape(&mut chance);
        let (solids, collider) = (shape.solids(), Collider::new(&shape).unwrap());
        for _ in 0..200 {
            let sweep = Sweep {
                from: chance.point(2.0),
                to: chance.point(0.5),
                radius: 0.05,
            };
            let Some(hit) = collider.first(&sweep) else {
                continue;
            };
            let out = Sweep {
                from: hit.position,
                to: hit.position + hit.normal * 1e-3,
                ..sweep
            };
            let back = Sweep {
                to: hit.position - hit.normal * 1e-3,
                ..out
            };
            let back = collider.first(&back).unwrap();
            assert!(back.time < 1e-6 && !back.pushed, "{hit:?} {back:?}");
            // Where another primitive is near, the way out may end there.
            let end = clearance(&solids, out.to, out.radius);
            if end > 0.9e-3 {
                assert_eq!(collider.first(&out), None, "{hit:?}");
                bounced += 1;
            }
        }
    }
    assert!(bounced > 500, "{bounced}");
}

#[test]
fn closed_cases_are_exact() {
    let point = DVec3::new;
    let of = |solid: Solid, from: DVec3, to: DVec3, radius: f64| {
        let collider = Collider::new(&single(&solid)).unwrap();
        collider.first(&Sweep { from, to, radius })
    };
    let near = |hit: Option<Hit>, time: f64, position: DVec3, normal: DVec3, pushed: bool| {
        let hit = hit.unwrap();
        assert!((hit.time - time).abs() < 1e-12, "{hit:?}");
        assert!(hit.position.distance(position) < 1e-12, "{hit:?}");
        assert!(hit.normal.distance(normal) < 1e-12, "{hit:?}");
        assert_eq!(hit.pushed, pushed);
    };
    let o = DVec3::ZERO;
    let sphere = || Solid::Ball(ball(o, 1.0));
    let (x, y, z) = (DVec3::X, DVec3::Y, DVec3::Z);
    near(
        of(sphere(), 4.0 * x, -4.0 * x, 0.5),
        0.3125,
        1.5 * x,
        x,
        false,
    );
    near(of(sphere(), 4.0 * x, 1.5 * x, 0.5), 1.0, 1.5 * x, x, false);
    assert_eq!(of(sphere(), 4.0 * x, 1.6 * x, 0.5), None);
    assert_eq!(of(sphere(), 4.0 * x, 9.0 * x, 0.5), None);
    near(of(sphere(), 0.5 * y, 9.0 * x, 0.5), 0.0, 1.5 * y, y, true);
    near(of(sphere(), 0.5 * y, 0.5 * y, 0.5), 0.0, 1.5 * y, y, true);
    assert_eq!(of(sphere(), 3.0 * y, 3.0 * y, 0.5), None);
    // A cone whose normals have sin φ = 0.6: at its middle the sphere of 0.7 touches along that normal.
    let cone = || Solid::Cone([ball(o, 1.0), ball(x, 0.4)]);
    let n = point(0.6, 0.8, 0.0);
    let touching = 0.5 * x + n * (0.7 + 0.25);
    near(
        of(cone(), touching + n, touching - n, 0.25),
        0.5,
        touching,
        n,
        false,
    );
    // A triangle whose plane leans as its radius falls: gradient -0.6 along x.
    let slab = || Solid::Slab([ball(o, 1.0), ball(x, 0.4), ball(y, 1.0)]);
    let n = point(0.6, 0.0, 0.8);
    let touching = 0.25 * x + 0.25 * y + n * (0.85 + 0.25);
    near(
        of(slab(), touching + n, touching - n, 0.25),
        0.5,
        touching,
        n,
        false,
    );
    let flip = |p: DVec3| point(p.x, p.y, -p.z);
    let hit = of(slab(), flip(touching + n), flip(touching - n), 0.25);
    near(hit, 0.5, flip(touching), flip(n), false);
    // On the axis of a capsule every way out is as short.
    let capsule = Solid::Cone([ball(o, 0.5), ball(x, 0.5)]);
    let hit = of(capsule, 0.5 * x, 0.5 * x, 0.1).unwrap();
    assert!(
        (hit.position.distance(0.5 * x) - 0.6).abs() < 1e-12 && hit.normal.dot(x).abs() < 1e-12
    );
    // The middle of a slab leaves through a face, not through an edge.
    let plate = Solid::Slab([ball(o, 0.1), ball(8.0 * x, 0.1), ball(8.0 * y, 0.1)]);
    let hit = of(plate, 2.0 * x + 2.0 * y, o, 0.0).unwrap();
    assert!((hit.position.z.abs() - 0.1).abs() < 1e-12 && hit.normal.z.abs() > 1.0 - 1e-12);
    // From far away, through a sheet without thickness, and right through the border of two.
    let sheet = Shape {
        balls: [o, x, y, x + y].map(|p| ball(p, 0.0)).to_vec(),
        triangles: vec![[0, 1, 2], [1, 2, 3]],
        edges: vec![],
    };
    let collider = Collider::new(&sheet).unwrap();
    for k in 1..100 {
        let t = f64::from(k) / 100.0;
        let through = point(t, 1.0 - t, 0.0);
        for side in [1.0, -1.0] {
            let way = point(0.3 * t, -0.2, side) * 1e6;
            let sweep = Sweep {
                from: through + way,
                to: through - way,
                radius: 0.0,
            };
            let hit = collider.first(&sweep).unwrap();
            assert!(hit.position.z.abs() < 1e-9 && !hit.pushed, "{hit:?}");
            assert_eq!(hit.normal, side * z);
        }
    }
}

#[test]
fn what_cannot_be_tested_is_refused() {
    let shape = Shape {
        balls: vec![ball(DVec3::ZERO, 1.0)],
        ..Shape::default()
    };
    let collider = Collider::new(&shape).unwrap();
    let good = Sweep {
        from: DVec3::X * 3.0,
        to: DVec3::ZERO,
        radius: 0.5,
    };
    assert_eq!(Collider::new(&Shape::default()).unwrap().first(&good), None);
    for bad in [
        Sweep {
            radius: -0.1,
            ..good
        },
        Sweep {
            radius: f64::NAN,
            ..good
        },
        Sweep {
            to: DVec3::new(0.0, f64::NAN, 0.0),
            ..good
        },
        Sweep {
            from: DVec3::X * f64::INFINITY,
            ..good
        },
        Sweep {
            from: DVec3::X * 1e61,
            ..good
        },
    ] {
        assert_eq!(collider.first(&bad), None);
        let error = collider.first_of_each(&[good, bad]).unwrap_err();
        assert!(error.to_string().starts_with("row 1: "), "{error}");
    }
    let mut bad = vec![shape.clone(); 4];
    bad[0].edges.push([0, 1]);
    bad[1].triangles.push([0, 0, 7]);
    bad[2].balls[0].radius = -1.0;
    bad[3].balls[0].centre.z = f64::NAN;
    let names = [
        "edge 0: [0, 1] of 1 ",
        "triangle 0: [0, 0, 7] of 1 ",
        "sphere 0",
        "sphere 0",
    ];
    for (shape, named) in bad.iter().zip(names) {
        let error = Collider::new(shape).unwrap_err().to_string();
        assert!(error.starts_with(named), "{error}");
    }
    // Sizes at both ends: an answer or none, never a number that is none.
    for size in [1e-200, 1e-100, 1e-50, 1e59] {
        let balls = [DVec3::ZERO, DVec3::X * size, DVec3::Y * size].map(|p| ball(p, size * 0.1));
        let sizes = Shape {
            balls: balls.to_vec(),
            triangles: vec![[0, 1, 2]],
            edges: vec![[0, 1]],
        };
        let sweep = Sweep {
            from: DVec3::new(0.2, 0.2, 1.0) * size,
            to: DVec3::new(0.2, 0.2, -1.0) * size,
            radius: 0.0,
        };
        if let Some(hit) = Collider::new(&sizes).unwrap().first(&sweep) {
            assert!(hit.time.is_finite() && hit.position.is_finite() && hit.normal.is_finite());
        }
    }
}
