//! The surface and its normals against those of rays traced in double precision.

use std::collections::HashSet;

use glam::{DMat4, DVec3, Vec3};

use super::*;
use crate::sphere_mesh::{Collider, Hit, Sweep};

const PIXELS: u32 = 900;
/// The device must find the surface this exactly; the shapes have a size of about 2.
const TOLERANCE: f64 = 4e-4;

/// The surface as rays through the corners of pixels see it: a pixel is a quad of four hits where its surface is even.
struct Traced {
    model_from_clip: DMat4,
    collider: Collider,
    from: Vec<DVec3>,
    hits: Vec<Option<Hit>>,
    /// Pixels, as columns and rows.
    even: Vec<[u32; 2]>,
}

impl Traced {
    fn new(shape: &Shape, camera: &Camera) -> Self {
        let model_from_clip = camera.clip_from_model(1.0).as_dmat4().inverse();
        let side = PIXELS + 1;
        let corners = (0..side.pow(2)).map(|i| [i % side, i / side].map(f64::from));
        let sweeps: Vec<Sweep> = corners
            .map(|[x, y]| sweep(&model_from_clip, x, y))
            .collect();
        let collider = Collider::new(shape).unwrap();
        let mut traced = Self {
            from: sweeps.iter().map(|s| s.from).collect(),
            hits: collider.first_of_each(&sweeps).unwrap(),
            even: Vec::new(),
            model_from_clip,
            collider,
        };
        traced.even = pixels().filter(|&pixel| traced.is_even(pixel)).collect();
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

    /// Whether the rays through corners and samples of a pixel all hit; where they pass between, corners tell too little.
    fn is_covered(&self, pixel: [u32; 2]) -> bool {
        const SAMPLES: [[f64; 2]; 4] = [
            [0.375, 0.125],
            [0.875, 0.375],
            [0.125, 0.625],
            [0.625, 0.875],
        ];
        let corners = Self::corners(pixel);
        let [x, y] = pixel.map(f64::from);
        let sweeps = SAMPLES.map(|[u, v]| sweep(&self.model_from_clip, x + u, y + v));
        corners.iter().all(|&row| self.hits[row].is_some())
            && self
                .collider
                .first_of_each(&sweeps)
                .unwrap()
                .iter()
                .all(Option::is_some)
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

fn pixels() -> impl Iterator<Item = [u32; 2]> {
    (0..PIXELS.pow(2)).map(|i| [i % PIXELS, i / PIXELS])
}

fn sweep(model_from_clip: &DMat4, x: f64, y: f64) -> Sweep {
    let to_clip = |k: f64| k * 2.0 / f64::from(PIXELS) - 1.0;
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
        let alone = renderer.draw_with(&scene(camera), &spheres).unwrap();
        for [x, y] in pixels() {
            let [red, _, blue, _] = alone.pixel(x, y);
            let shown = red > blue;
            assert!(
                shown || !traced.is_covered([x, y]),
                "{camera:?} {x} {y}: {red} {blue}"
            );
        }
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
