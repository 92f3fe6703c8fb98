#![allow(clippy::unwrap_used)]
use glam::Vec3;

use super::*;
use crate::gpu::testing;

struct Sphere {
    positions: Vec<Vec3>,
    normals: Vec<Vec3>,
    triangles: Vec<[u32; 3]>,
}

/// A sphere of `rings` × 2 `rings` cells, wound counter-clockwise seen from outside.
fn sphere(centre: Vec3, radius: f32, rings: u32) -> Sphere {
    let columns = 2 * rings;
    let point = |i: u32| {
        let (ring, column) = (i / (columns + 1), i % (columns + 1));
        let polar = std::f32::consts::PI * ring as f32 / rings as f32;
        let turn = std::f32::consts::TAU * column as f32 / columns as f32;
        Vec3::new(
            polar.sin() * turn.sin(),
            polar.cos(),
            polar.sin() * turn.cos(),
        )
    };
    let normals: Vec<Vec3> = (0..(rings + 1) * (columns + 1)).map(point).collect();
    let cell = |i: u32| {
        let a = i / columns * (columns + 1) + i % columns;
        let b = a + columns + 1;
        [[a, b, b + 1], [a, b + 1, a + 1]]
    };
    Sphere {
        positions: normals.iter().map(|n| centre + n * radius).collect(),
        triangles: (0..rings * columns).flat_map(cell).collect(),
        normals,
    }
}

fn camera() -> Camera {
    let bounds = Bounds::of(&[Vec3::X, Vec3::Y, -Vec3::X, -Vec3::Y, Vec3::Z, -Vec3::Z]);
    let projection = Projection::Orthographic { height: 0.0 };
    Camera::framing(&bounds, View::Front, projection, 1.0)
}

const BLUE: Background = Background {
    top: [0, 0, 255],
    bottom: [0, 0, 255],
};

fn draw(renderer: &mut Renderer, mesh: &Sphere, colour: Vec3, wireframe: bool) -> Picture {
    let colours = vec![colour; mesh.positions.len()];
    renderer
        .draw(&Scene {
            positions: &mesh.positions,
            normals: &mesh.normals,
            colours: &colours,
            triangles: &mesh.triangles,
            camera: camera(),
            wireframe,
            background: BLUE,
        })
        .unwrap()
}

fn brightness(pixel: [u8; 4]) -> u32 {
    pixel[..3].iter().map(|&c| c as u32).sum()
}

#[test]
fn a_lit_sphere_has_the_area_of_its_silhouette_and_a_bright_centre() {
    let Some(gpu) = testing::gpu() else { return };
    let mut renderer = Renderer::new(&gpu, 200, 200).unwrap();
    let mesh = sphere(Vec3::ZERO, 1.0, 40);
    let picture = draw(&mut renderer, &mesh, Vec3::splat(0.6), false);
    let covered = picture.rgba.chunks(4).filter(|p| p[0] > 20).count() as f32;
    // The box fills 92 % of the height, so the disc's radius is 92 pixels; edge pixels count by half on average.
    let expected = std::f32::consts::PI * 92.0 * 92.0;
    assert!(
        (covered / expected - 1.0).abs() < 0.02,
        "{covered} {expected}"
    );
    let (centre, edge) = (picture.pixel(100, 100), picture.pixel(100, 189));
    assert!(
        brightness(centre) > brightness(edge) + 60,
        "{centre:?} {edge:?}"
    );
    assert_eq!(picture.pixel(2, 2), [0, 0, 255, 255]);
}

#[test]
fn edges_are_antialiased() {
    let Some(gpu) = testing::gpu() else { return };
    let mut renderer = Renderer::new(&gpu, 100, 100).unwrap();
    let picture = draw(
        &mut renderer,
        &sphere(Vec3::ZERO, 1.0, 30),
        Vec3::ONE,
        false,
    );
    let blue = |p: &[u8]| p[2] as i32 - p[0] as i32;
    let partial = picture
        .rgba
        .chunks(4)
        .map(blue)
        .filter(|b| (40..220).contains(b));
    assert!(partial.count() > 60);
}

#[test]
fn back_faces_get_the_back_colour() {
    let Some(gpu) = testing::gpu() else { return };
    let mut renderer = Renderer::new(&gpu, 64, 64).unwrap();
    let mut mesh = sphere(Vec3::ZERO, 1.0, 16);
    let front = draw(&mut renderer, &mesh, Vec3::new(0.2, 0.6, 0.2), false).pixel(32, 32);
    mesh.triangles.iter_mut().for_each(|t| t.swap(1, 2));
    let back = draw(&mut renderer, &mesh, Vec3::new(0.2, 0.6, 0.2), false).pixel(32, 32);
    assert!(front[1] > front[0] && front[1] > front[2], "{front:?}");
    assert!(back[0] > 2 * back[1] && back[2] > 2 * back[1], "{back:?}");
}

#[test]
fn the_nearer_surface_hides_the_farther_in_any_order() {
    let Some(gpu) = testing::gpu() else { return };
    let mut renderer = Renderer::new(&gpu, 64, 64).unwrap();
    let (near, far) = (
        sphere(Vec3::Z * 0.5, 0.4, 12),
        sphere(Vec3::Z * -0.5, 0.4, 12),
    );
    for order in [[&near, &far], [&far, &near]] {
        let rows = near.positions.len();
        let colour = |mesh: &Sphere| {
            let red = std::ptr::eq(mesh, &near);
            vec![if red { Vec3::X } else { Vec3::Y }; rows]
        };
        let second = order[1]
            .triangles
            .iter()
            .map(|t| t.map(|i| i + rows as u32));
        let picture = renderer
            .draw(&Scene {
                positions: &order.map(|m| &m.positions[..]).concat(),
                normals: &order.map(|m| &m.normals[..]).concat(),
                colours: &order.map(colour).concat(),
                triangles: &order[0]
                    .triangles
                    .iter()
                    .copied()
                    .chain(second)
                    .collect::<Vec<_>>(),
                camera: camera(),
                wireframe: false,
                background: BLUE,
            })
            .unwrap();
        let centre = picture.pixel(32, 32);
        assert!(centre[0] > centre[1] + 80, "{centre:?}");
    }
}

#[test]
fn a_wireframe_darkens_edges_only() {
    let Some(gpu) = testing::gpu() else { return };
    let mut renderer = Renderer::new(&gpu, 200, 200).unwrap();
    let mesh = sphere(Vec3::ZERO, 1.0, 8);
    let plain = draw(&mut renderer, &mesh, Vec3::splat(0.7), false);
    let wired = draw(&mut renderer, &mesh, Vec3::splat(0.7), true);
    let pairs = plain.rgba.chunks(4).zip(wired.rgba.chunks(4));
    let darker = pairs
        .clone()
        .filter(|(a, b)| b[0] < a[0].saturating_sub(25))
        .count() as f32;
    let same = pairs.filter(|(a, b)| a == b).count() as f32;
    let pixels = 200.0 * 200.0;
    assert!((0.03..0.3).contains(&(darker / pixels)), "{darker}");
    assert!(same / pixels > 0.5, "{same}");
}

#[test]
fn two_runs_and_two_renderers_give_the_same_bits() {
    let Some(gpu) = testing::gpu() else { return };
    let mesh = sphere(Vec3::ZERO, 0.9, 24);
    let mut renderer = Renderer::new(&gpu, 120, 90).unwrap();
    let first = draw(&mut renderer, &mesh, Vec3::splat(0.5), true);
    // A larger scene in between, so that buffers are made anew and reused.
    draw(&mut renderer, &sphere(Vec3::ZERO, 1.0, 40), Vec3::X, false);
    let again = draw(&mut renderer, &mesh, Vec3::splat(0.5), true);
    let mut other = Renderer::new(&gpu, 120, 90).unwrap();
    assert_eq!(first, again);
    assert_eq!(first, draw(&mut other, &mesh, Vec3::splat(0.5), true));
}

#[test]
fn bad_scenes_are_refused_by_name_and_empty_ones_drawn() {
    let Some(gpu) = testing::gpu() else { return };
    let mut renderer = Renderer::new(&gpu, 16, 16).unwrap();
    let empty = Scene {
        positions: &[],
        normals: &[],
        colours: &[],
        triangles: &[],
        camera: camera(),
        wireframe: false,
        background: BLUE,
    };
    assert_eq!(renderer.draw(&empty).unwrap().pixel(8, 8), [0, 0, 255, 255]);
    let points = [Vec3::ZERO; 3];
    let cases: [(Scene, &str); 2] = [
        (
            Scene {
                positions: &points,
                colours: &points,
                ..empty
            },
            "normals: 0 rows for 3 positions",
        ),
        (
            Scene {
                positions: &points,
                normals: &points,
                colours: &points,
                triangles: &[[0, 1, 2], [0, 1, 3]],
                ..empty
            },
            "triangle 1: [0, 1, 3] of 3 vertices",
        ),
    ];
    for (scene, message) in cases {
        assert_eq!(renderer.draw(&scene).unwrap_err().to_string(), message);
    }
    assert!(Renderer::new(&gpu, 0, 16).is_err());
    assert!(Renderer::new(&gpu, 16, 1 << 30).is_err());
}

#[test]
fn a_turntable_frame_keeps_the_character_inside() {
    let Some(gpu) = testing::gpu() else { return };
    let mut renderer = Renderer::new(&gpu, 96, 96).unwrap();
    let mesh = sphere(Vec3::new(3.0, 1.0, 0.5), 0.8, 16);
    let framing = Bounds::of(&mesh.positions).turned();
    let camera = Camera::framing(&framing, View::ThreeQuarter, Projection::default(), 1.0);
    for degrees in [0.0, 120.0, 240.0] {
        let picture = renderer
            .draw(&Scene {
                positions: &mesh.positions,
                normals: &mesh.normals,
                colours: &vec![Vec3::ONE; mesh.positions.len()],
                triangles: &mesh.triangles,
                camera: camera.orbit(degrees),
                wireframe: false,
                background: BLUE,
            })
            .unwrap();
        assert!(picture.pixel(48, 48)[0] > 40);
        let border = (0..96).flat_map(|i| [(i, 0), (0, i), (i, 95), (95, i)]);
        assert!(
            border
                .into_iter()
                .all(|(x, y)| picture.pixel(x, y) == [0, 0, 255, 255])
        );
    }
}
