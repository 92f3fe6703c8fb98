//! Pictures of spheres against rays traced in double precision, and against meshes.
#![allow(clippy::unwrap_used)]

use std::collections::HashSet;

use glam::{DMat4, DVec3, Vec3};

use super::*;
use crate::{
    gpu::{Features, GpuOptions, testing},
    sphere_mesh::{Ball, Collider, Hit, Shape, Sweep, extract},
};

const BLUE: Background = Background {
    top: [0, 0, 255],
    bottom: [0, 0, 255],
};

fn ball(x: f64, y: f64, z: f64, radius: f64) -> Ball {
    Ball {
        centre: DVec3::new(x, y, z),
        radius,
    }
}

fn shape(balls: &[Ball], edges: &[[u32; 2]], triangles: &[[u32; 3]]) -> Shape {
    Shape {
        balls: balls.to_vec(),
        edges: edges.to_vec(),
        triangles: triangles.to_vec(),
    }
}

/// Cones and slabs of unlike radii, one end and one side of radius 0, a lone sphere, and a sheet without thickness.
fn solids() -> Shape {
    let balls = [
        ball(-0.9, -0.5, 0.1, 0.30),
        ball(0.0, -0.6, -0.2, 0.10),
        ball(-0.4, 0.4, 0.0, 0.22),
        ball(0.5, 0.3, 0.3, 0.0),
        ball(0.9, -0.4, 0.0, 0.0),
        ball(0.9, 0.8, -0.1, 0.15),
        ball(0.2, 0.9, 0.2, 0.08),
        ball(-0.9, 0.9, 0.0, 0.12),
        ball(-0.2, 1.2, -0.3, 0.0),
        ball(0.3, 1.3, -0.3, 0.0),
        ball(0.1, 1.7, -0.1, 0.0),
    ];
    let triangles = [[0, 1, 2], [1, 2, 3], [1, 3, 4], [8, 9, 10]];
    shape(&balls, &[[3, 5], [5, 6], [2, 7]], &triangles)
}

fn surface(shape: &Shape, colour: Vec3) -> Spheres {
    let mut spheres = Spheres::default();
    let colours = vec![colour; shape.balls.len()];
    spheres.surface(shape, &colours).unwrap();
    spheres
}

fn scene(camera: Camera) -> Scene<'static> {
    Scene {
        positions: &[],
        normals: &[],
        colours: &[],
        triangles: &[],
        camera,
        wireframe: false,
        background: BLUE,
    }
}

fn cameras(bounds: &Bounds) -> [Camera; 3] {
    let parallel = Projection::Orthographic { height: 0.0 };
    [
        Camera::framing(bounds, View::Front, Projection::default(), 1.0),
        Camera::framing(bounds, View::ThreeQuarter, parallel, 1.0).orbit(150.0),
        // A wide lens from near, so that rays differ in direction.
        Camera {
            projection: Projection::Perspective { degrees: 75.0 },
            ..Camera::standing(Vec3::new(0.5, 0.9, 2.0), Vec3::new(0.0, 0.4, 0.0), bounds).unwrap()
        },
    ]
}

const PIXELS: u32 = 900;
/// The device must find the surface this exactly; the shapes have a size of about 2.
const TOLERANCE: f64 = 4e-4;

/// The surface as rays through the corners of pixels see it: a pixel is a quad of four hits where its surface is even.
struct Traced {
    from: Vec<DVec3>,
    hits: Vec<Option<Hit>>,
    /// Pixels, as columns and rows.
    even: Vec<[u32; 2]>,
}

impl Traced {
    fn new(shape: &Shape, camera: &Camera) -> Self {
        let model_from_clip = camera.clip_from_model(1.0).as_dmat4().inverse();
        let sweeps: Vec<Sweep> = (0..(PIXELS + 1).pow(2))
            .map(|i| sweep(&model_from_clip, i % (PIXELS + 1), i / (PIXELS + 1)))
            .collect();
        let collider = Collider::new(shape).unwrap();
        let mut traced = Self {
            from: sweeps.iter().map(|s| s.from).collect(),
            hits: collider.first_of_each(&sweeps).unwrap(),
            even: Vec::new(),
        };
        let pixels = (0..PIXELS.pow(2)).map(|i| [i % PIXELS, i / PIXELS]);
        traced.even = pixels.filter(|&pixel| traced.is_even(pixel)).collect();
        let seen = traced.hits.iter().flatten().count();
        assert!(
            traced.even.len() > seen / 2,
            "{} of {seen}",
            traced.even.len()
        );
        traced
    }

    /// Rows of a pixel's corners, around it.
    fn corners([x, y]: [u32; 2]) -> [usize; 4] {
        [[x, y], [x, y + 1], [x + 1, y + 1], [x + 1, y]]
            .map(|[x, y]| (y * (PIXELS + 1) + x) as usize)
    }

    /// Whether the tangent planes of the corners are nearly one, and rays do not just graze it.
    fn is_even(&self, pixel: [u32; 2]) -> bool {
        let rows = Self::corners(pixel);
        let Some(hits) = rows
            .iter()
            .map(|&row| self.hits[row])
            .collect::<Option<Vec<_>>>()
        else {
            return false;
        };
        let holds = |a: &Hit, b: &Hit| {
            let off = (b.position - a.position).dot(a.normal).abs();
            off < TOLERANCE / 2.0 && a.normal.dot(b.normal) > 0.997
        };
        let along = (hits[0].position - self.from[rows[0]]).normalize();
        let all = |a: &Hit| hits.iter().all(|b| holds(a, b)) && a.normal.dot(along) < -0.2;
        hits.iter().all(all)
    }

    /// The even pixels as a mesh, `nearer` to the viewer than the surface.
    fn mesh(&self, nearer: f64) -> (Vec<Vec3>, Vec<Vec3>, Vec<[u32; 3]>) {
        let (mut positions, mut normals, mut triangles) = (Vec::new(), Vec::new(), Vec::new());
        for &pixel in &self.even {
            let first = positions.len() as u32;
            for row in Self::corners(pixel) {
                let hit = self.hits[row].unwrap();
                let along = (hit.position - self.from[row]).normalize();
                positions.push((hit.position - along * nearer).as_vec3());
                normals.push(hit.normal.as_vec3());
            }
            triangles.extend([[0, 1, 2], [0, 2, 3]].map(|t: [u32; 3]| t.map(|v| first + v)));
        }
        (positions, normals, triangles)
    }
}

fn sweep(model_from_clip: &DMat4, x: u32, y: u32) -> Sweep {
    let to_clip = |k: u32| f64::from(k) * 2.0 / f64::from(PIXELS) - 1.0;
    let at = |depth| model_from_clip.project_point3(DVec3::new(to_clip(x), to_clip(y), depth));
    Sweep {
        from: at(0.0),
        to: at(1.0),
        radius: 0.0,
    }
}

#[test]
fn the_surface_lies_between_two_traced_ones_a_hair_apart() {
    let Some(gpu) = testing::gpu() else { return };
    let mut renderer = Renderer::new(&gpu, PIXELS, PIXELS).unwrap();
    let shape = solids();
    let spheres = surface(&shape, Vec3::X);
    for camera in cameras(&spheres.bounds()) {
        let traced = Traced::new(&shape, &camera);
        for (nearer, hidden) in [(TOLERANCE, true), (-TOLERANCE, false)] {
            let (positions, normals, triangles) = traced.mesh(nearer);
            let scene = Scene {
                positions: &positions,
                normals: &normals,
                colours: &vec![Vec3::Y; positions.len()],
                triangles: &triangles,
                ..scene(camera)
            };
            let picture = renderer.draw_with(&scene, &spheres).unwrap();
            for &[x, y] in &traced.even {
                let [red, green, ..] = picture.pixel(x, y);
                let (more, less) = if hidden { (green, red) } else { (red, green) };
                assert!(
                    more > less.saturating_add(25),
                    "{camera:?} {x} {y} {nearer}: {red} {green}"
                );
            }
        }
    }
}

#[test]
fn normals_are_those_of_the_traced_surface() {
    let Some(gpu) = testing::gpu() else { return };
    let mut renderer = Renderer::new(&gpu, PIXELS, PIXELS).unwrap();
    let shape = solids();
    let colour = Vec3::splat(0.6);
    let spheres = surface(&shape, colour);
    for camera in cameras(&spheres.bounds()) {
        let traced = Traced::new(&shape, &camera);
        let (positions, normals, triangles) = traced.mesh(0.0);
        let mesh = Scene {
            positions: &positions,
            normals: &normals,
            colours: &vec![colour; positions.len()],
            triangles: &triangles,
            ..scene(camera)
        };
        let expected = renderer.draw(&mesh).unwrap();
        let found = renderer.draw_with(&scene(camera), &spheres).unwrap();
        // Skin's shader looks at the pixels of its block of four, which must not lie across an edge of the surface.
        let even: HashSet<[u32; 2]> = traced.even.iter().copied().collect();
        let whole = |&&[x, y]: &&[u32; 2]| {
            [[x ^ 1, y], [x, y ^ 1], [x ^ 1, y ^ 1]]
                .iter()
                .all(|p| even.contains(p))
        };
        let (mut sum, mut most) = (0, 0);
        for &[x, y] in traced.even.iter().filter(whole) {
            let off = found.pixel(x, y)[0].abs_diff(expected.pixel(x, y)[0]);
            sum += u32::from(off);
            most = most.max(off);
        }
        // Skin brightens ridges by up to 7 %; light falls by about 150 levels over a right angle.
        let mean = f64::from(sum) / traced.even.len() as f64;
        assert!(mean < 1.0 && most <= 18, "{camera:?}: {mean} {most}");
    }
}

/// Whether a pixel is at least half covered by something white before blue.
fn covered(picture: &Picture, x: u32, y: u32) -> bool {
    picture.pixel(x, y)[0] > 60
}

#[test]
fn outlines_are_those_of_the_extracted_surface() {
    let Some(gpu) = testing::gpu() else { return };
    let mut renderer = Renderer::new(&gpu, 300, 300).unwrap();
    // Without the sheet and the sides of no radius, which extraction thickens.
    let mut shape = solids();
    shape
        .balls
        .iter_mut()
        .for_each(|b| b.radius = b.radius.max(0.05));
    let skin = extract(&shape, 300).unwrap();
    let positions: Vec<Vec3> = skin.positions.iter().map(|p| p.as_vec3()).collect();
    let spheres = surface(&shape, Vec3::ONE);
    for camera in cameras(&spheres.bounds()) {
        let found = renderer.draw_with(&scene(camera), &spheres).unwrap();
        let mesh = Scene {
            positions: &positions,
            normals: &vec![Vec3::ZERO; positions.len()],
            colours: &vec![Vec3::ONE; positions.len()],
            triangles: &skin.triangles,
            ..scene(camera)
        };
        let expected = renderer.draw(&mesh).unwrap();
        let inner = (0..300 * 300).map(|i| (i % 300, i / 300));
        let inner: Vec<_> = inner
            .filter(|&(x, y)| x.min(y) > 0 && x.max(y) < 299)
            .collect();
        let mut both = 0;
        for &(x, y) in &inner {
            let is = covered(&found, x, y);
            both += u32::from(is && covered(&expected, x, y));
            if is != covered(&expected, x, y) {
                let around = (0..9).map(|k| covered(&expected, x + k % 3 - 1, y + k / 3 - 1));
                assert!(around.clone().any(|c| c == is), "{camera:?}: {x} {y}");
            }
        }
        assert!(both > 10_000, "{both}");
    }
}

fn front(bounds: &Bounds) -> Camera {
    Camera::framing(bounds, View::Front, Projection::default(), 1.0)
}

/// What there is to see of a solid without a cone or slab is what there is without it.
#[test]
fn solids_that_are_not_there_leave_no_trace() {
    let Some(gpu) = testing::gpu() else { return };
    let mut renderer = Renderer::new(&gpu, 160, 160).unwrap();
    let (a, b, c) = (
        ball(0., 0., 0., 0.5),
        ball(0.8, 0.1, 0., 0.2),
        ball(0.2, 0.9, 0.1, 0.3),
    );
    let within = ball(0.1, 0.1, 0.0, 0.2);
    let point = ball(0.3, 0.2, 0.1, 0.0);
    let on_line = ball(0.4, 0.05, 0.0, 0.35);
    let wide = ball(0.35, 0.5, 0.1, 0.9);
    let cones = [[0, 1], [1, 2], [0, 2]];
    let pairs = [
        (shape(&[a, within], &[[0, 1]], &[]), shape(&[a], &[], &[])),
        (shape(&[a, a], &[[0, 1]], &[]), shape(&[a], &[], &[])),
        (shape(&[a, point], &[[0, 1]], &[]), shape(&[a], &[], &[])),
        (shape(&[a, a, a], &[], &[[0, 1, 2]]), shape(&[a], &[], &[])),
        (
            shape(&[a, b, b], &[], &[[0, 1, 2]]),
            shape(&[a, b], &[[0, 1]], &[]),
        ),
        (
            shape(&[a, b, on_line], &[], &[[0, 1, 2]]),
            shape(&[a, b, on_line], &cones, &[]),
        ),
        (
            shape(&[a, b, wide], &[], &[[0, 1, 2]]),
            shape(&[a, b, wide], &cones, &[]),
        ),
        (
            shape(&[point; 3], &[[0, 1]], &[[0, 1, 2]]),
            Shape::default(),
        ),
    ];
    for (degenerate, plain) in pairs {
        let all = shape(&[a, b, c, wide], &[], &[]);
        let camera = front(&surface(&all, Vec3::ONE).bounds());
        let mut draw = |shape: &Shape| {
            let spheres = surface(shape, Vec3::ONE);
            renderer.draw_with(&scene(camera), &spheres).unwrap()
        };
        assert_eq!(draw(&degenerate), draw(&plain), "{degenerate:?}");
    }
}

/// White in any light is never dark, and neither is blue: dark are only pixels that are not numbers.
#[test]
fn no_pixel_is_not_a_number() {
    let Some(gpu) = testing::gpu() else { return };
    let mut renderer = Renderer::new(&gpu, 96, 96).unwrap();
    let flat = |h: f64, r: f64| {
        let balls = [
            ball(0., 0., 0., r),
            ball(1., 0., 0., 0.7 * r),
            ball(0.5, h, 0., r),
        ];
        shape(&balls, &[], &[[0, 1, 2]])
    };
    let scaled = |scale: f64| {
        let mut shape = solids();
        for ball in &mut shape.balls {
            ball.centre *= scale;
            ball.radius *= scale;
        }
        shape
    };
    let mut shapes: Vec<Shape> = [1e-30, 1e-12, 1e-6, 1e6, 1e18, 1e36].map(scaled).into();
    for h in [0.0, 1e-30, 1e-12, 1e-7, 1e-5, 1e-3, 0.1] {
        shapes.extend([0.0, 1e-30, 1e-6, 0.2].map(|r| flat(h, r)));
    }
    for slope in [0.999, 0.9999999, 1.0, 1.0000001] {
        let balls = [
            ball(0., 0., 0., 1.0),
            ball(1., 0., 0., 1.0 + slope),
            ball(0., 1., 0., 1.0),
        ];
        shapes.push(shape(&balls, &[[0, 1]], &[[0, 1, 2]]));
    }
    for shape in shapes {
        let spheres = surface(&shape, Vec3::ONE);
        let framed = front(&spheres.bounds());
        let (eye, far) = (shape.balls[0].centre.as_vec3(), framed.eye);
        // From outside; from inside a sphere; from within the plane of the triangles; looking away.
        let mut cameras = vec![framed, framed.orbit(90.0)];
        cameras.extend(
            [
                (eye, far),
                (eye - (far - eye), eye),
                (far, far + (far - eye)),
            ]
            .iter()
            .filter_map(|&(eye, target)| Camera::standing(eye, target, &spheres.bounds()).ok()),
        );
        for camera in cameras {
            let picture = renderer.draw_with(&scene(camera), &spheres).unwrap();
            let dark = picture.rgba.chunks(4).position(|p| p[2] < 80);
            assert_eq!(dark, None, "{shape:?} {camera:?}");
        }
    }
}

#[test]
fn a_sheet_without_thickness_is_seen_from_both_sides_and_edge_on_not_at_all() {
    let Some(gpu) = testing::gpu() else { return };
    let mut renderer = Renderer::new(&gpu, 100, 100).unwrap();
    let balls = [
        ball(-1., -1., 0., 0.),
        ball(1., -1., 0., 0.),
        ball(0., 1., 0., 0.),
    ];
    let spheres = surface(&shape(&balls, &[], &[[0, 1, 2]]), Vec3::ONE);
    let camera = front(&spheres.bounds());
    let mut share = |degrees: f32| {
        let picture = renderer
            .draw_with(&scene(camera.orbit(degrees)), &spheres)
            .unwrap();
        picture.rgba.chunks(4).filter(|p| p[0] > 60).count()
    };
    // Half of a square whose side fills 92 % of the picture.
    let half = 92 * 92 / 2;
    assert!(share(0.0).abs_diff(half) < 150 && share(180.0).abs_diff(half) < 150);
    assert!(share(90.0) < 3);
}

#[test]
fn loose_spheres_hide_and_are_hidden_in_their_colours() {
    let Some(gpu) = testing::gpu() else { return };
    let mut renderer = Renderer::new(&gpu, 90, 90).unwrap();
    let body = shape(
        &[ball(-1., 0., 0., 0.3), ball(1., 0., 0., 0.3)],
        &[[0, 1]],
        &[],
    );
    let mut spheres = Spheres::default();
    spheres.surface(&body, &[Vec3::X, Vec3::Y]).unwrap();
    let drops = [
        ball(-0.5, 0., 1., 0.1),
        ball(0.5, 0., -1., 0.1),
        ball(0., 0.8, 0., 0.1),
    ];
    spheres.loose(&drops, &[Vec3::ONE; 3]).unwrap();
    let bounds = Bounds::of(&[Vec3::splat(-1.3), Vec3::splat(1.3)]);
    let camera = Camera::framing(
        &bounds,
        View::Front,
        Projection::Orthographic { height: 0.0 },
        1.0,
    );
    let picture = renderer.draw_with(&scene(camera), &spheres).unwrap();
    let at = |p: Vec3| {
        let clip = camera.clip_from_model(1.0).project_point3(p) * 45.0 + 45.0;
        picture.pixel(clip.x as u32, clip.y as u32)
    };
    let is = |p: Vec3, wanted: [bool; 3]| {
        let pixel = at(p);
        assert_eq!([0, 1, 2].map(|k| pixel[k] > 110), wanted, "{p} {pixel:?}");
    };
    is(Vec3::new(-0.5, 0., 0.), [true; 3]);
    is(Vec3::new(0.0, 0.8, 0.), [true; 3]);
    is(Vec3::new(0.5, 0., 0.), [false, true, false]);
    is(Vec3::new(-1.1, 0., 0.), [true, false, false]);
    is(Vec3::new(-0.1, 0., 0.), [true, false, false]);
    is(Vec3::new(0.1, 0., 0.), [false, true, false]);
    is(Vec3::new(0.0, -0.8, 0.), [false, false, true]);
}

#[test]
fn a_skeleton_shows_spheres_wires_and_what_is_behind_its_sheets() {
    let Some(gpu) = testing::gpu() else { return };
    let mut renderer = Renderer::new(&gpu, 200, 200).unwrap();
    let balls = [
        ball(-1., -1., 0., 0.5),
        ball(1., -1., 0., 0.5),
        ball(0., 1., 0., 0.),
    ];
    let body = shape(&balls, &[], &[[0, 1, 2]]);
    let behind = ball(0., -0.3, -1., 0.2);
    let bounds = Bounds::of(&[Vec3::splat(-1.2), Vec3::splat(1.2)]);
    let camera = Camera::framing(
        &bounds,
        View::Front,
        Projection::Orthographic { height: 0.0 },
        1.0,
    );
    let at = |picture: &Picture, x: f32, y: f32| {
        let clip = camera
            .clip_from_model(1.0)
            .project_point3(Vec3::new(x, y, 0.0))
            * 100.0
            + 100.0;
        picture.pixel(clip.x as u32, clip.y as u32)
    };
    let mut pictures = Vec::new();
    // The order in which they are added makes no difference to what can be seen through.
    for last in [false, true] {
        let mut spheres = Spheres::default();
        if !last {
            spheres.loose(&[behind], &[Vec3::X]).unwrap();
        }
        spheres.skeleton(&body, &[Vec3::ONE; 3], 0.1).unwrap();
        if last {
            spheres.loose(&[behind], &[Vec3::X]).unwrap();
        }
        pictures.push(renderer.draw_with(&scene(camera), &spheres).unwrap());
    }
    assert_eq!(pictures[0], pictures[1]);
    let [ball, wire, sheet, through] =
        [(-1.0, -1.0), (0.0, -1.0), (0.0, 0.2), (0.0, -0.3)].map(|(x, y)| at(&pictures[0], x, y));
    assert!(ball[0] > 150, "{ball:?}");
    assert!(wire[..3].iter().all(|&c| c < 110), "{wire:?}");
    assert!((30..140).contains(&sheet[0]) && sheet[2] > 200, "{sheet:?}");
    assert!(through[0] > 150 && through[2] < 120, "{through:?}");
    assert_eq!(at(&pictures[0], 0.9, 0.9), [0, 0, 255, 255]);
}

#[test]
fn without_shading_a_sample_only_edges_differ_and_two_runs_never() {
    let Some(gpu) = testing::gpu() else { return };
    let coarse = Features {
        sample_shading: false,
        ..Features::ALL
    };
    let Some(plain) = testing::with(&GpuOptions::default(), coarse) else {
        return;
    };
    let spheres = surface(&solids(), Vec3::splat(0.6));
    let camera = front(&spheres.bounds());
    let draw = |gpu| {
        let mut renderer = Renderer::new(gpu, 200, 200).unwrap();
        renderer.draw_with(&scene(camera), &spheres).unwrap()
    };
    let (fine, coarse) = (draw(&gpu), draw(&plain));
    assert_eq!(fine, draw(&gpu));
    let pairs = fine.rgba.chunks(4).zip(coarse.rgba.chunks(4));
    let off = |(a, b): (&[u8], &[u8])| a.iter().zip(b).map(|(a, b)| a.abs_diff(*b)).max();
    let differ = pairs.filter(|&pair| off(pair) > Some(3)).count();
    assert!((200..3000).contains(&differ), "{differ}");
}

#[test]
fn bad_shapes_are_refused_by_name_and_empty_ones_drawn() {
    let mut spheres = Spheres::default();
    let one = [ball(0., 0., 0., 1.)];
    let mut refused = |shape: &Shape, colours: usize, message: &str| {
        let colours = vec![Vec3::ONE; colours];
        for error in [
            spheres.surface(shape, &colours).unwrap_err(),
            spheres.skeleton(shape, &colours, 0.1).unwrap_err(),
        ] {
            assert!(error.to_string().starts_with(message), "{error}");
        }
        assert!(spheres.primitives.is_empty());
    };
    refused(
        &shape(&one, &[[0, 1]], &[]),
        1,
        "edge 0: [0, 1] of 1 spheres",
    );
    refused(
        &shape(&one, &[], &[[0, 0, 2]]),
        1,
        "triangle 0: [0, 0, 2] of 1 spheres",
    );
    refused(&shape(&one, &[], &[]), 2, "colours: 2 rows for 1 spheres");
    for bad in [ball(f64::NAN, 0., 0., 1.), ball(1e39, 0., 0., 1.)] {
        refused(&shape(&[one[0], bad], &[], &[]), 2, "sphere 1: radius 1 at");
    }
    let negative = shape(&[ball(0., 0., 0., -1.)], &[], &[]);
    assert!(Spheres::default().surface(&negative, &[Vec3::ONE]).is_err());
    let Some(gpu) = testing::gpu() else { return };
    let mut renderer = Renderer::new(&gpu, 16, 16).unwrap();
    let empty = surface(&Shape::default(), Vec3::ONE);
    let camera = front(&empty.bounds());
    let drawn = renderer.draw_with(&scene(camera), &empty).unwrap();
    assert_eq!(drawn, renderer.draw(&scene(camera)).unwrap());
}
