//! Pictures of spheres against rays traced in double precision, and against meshes.
#![allow(clippy::unwrap_used)]

mod degenerate;
mod traced;

use glam::{DVec3, Vec3};

use super::*;
use crate::{
    gpu::{Features, GpuOptions, testing},
    sphere_mesh::{Ball, Shape, extract},
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

fn front(bounds: &Bounds) -> Camera {
    Camera::framing(bounds, View::Front, Projection::default(), 1.0)
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

#[test]
fn framed_spheres_are_seen_whole_and_fill_the_picture() {
    let Some(gpu) = testing::gpu() else { return };
    let mut renderer = Renderer::new(&gpu, 100, 100).unwrap();
    for balls in [
        [ball(3., 1., 0.5, 0.8); 2],
        [ball(0., 0., 0., 0.1), ball(2., 0.5, -3., 0.7)],
    ] {
        let spheres = surface(&shape(&balls, &[[0, 1]], &[]), Vec3::ONE);
        for view in [View::Front, View::Side, View::Top, View::ThreeQuarter] {
            let camera = Camera::framing(&spheres.bounds(), view, Projection::default(), 1.0);
            let picture = renderer.draw_with(&scene(camera), &spheres).unwrap();
            let at = |distance: u32| {
                let last = 99 - distance;
                let mut ring = (distance..=last)
                    .flat_map(|i| [(i, distance), (distance, i), (i, last), (last, i)]);
                ring.any(|(x, y)| covered(&picture, x, y))
            };
            assert!(!at(0) && !at(1) && at(8), "{balls:?} {view:?}");
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
    let dark = [Vec3::new(0.0, f32::NAN, 0.0)];
    let error = Spheres::default().loose(&one, &dark).unwrap_err();
    assert!(
        error.to_string().starts_with("colours: row 0 is"),
        "{error}"
    );
    let Some(gpu) = testing::gpu() else { return };
    let mut renderer = Renderer::new(&gpu, 16, 16).unwrap();
    let empty = surface(&Shape::default(), Vec3::ONE);
    let camera = front(&empty.bounds());
    let drawn = renderer.draw_with(&scene(camera), &empty).unwrap();
    assert_eq!(drawn, renderer.draw(&scene(camera)).unwrap());
}
