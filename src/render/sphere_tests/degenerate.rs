//! Shapes without a cone or slab, and those at the end of what numbers hold.

use glam::Vec3;

use super::*;

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
