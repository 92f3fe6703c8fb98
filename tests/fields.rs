//! Fields of real characters: what the projection relies on, and the GPU's grids against their twin.
#![allow(clippy::unwrap_used)]

mod common;

use std::sync::OnceLock;

use dermis::{
    field::{AtlasLayout, Field, GridInput, atlas_layout},
    frame::FrameBuilder,
    gpu::{Class, Format, Gpu},
    pass::field_grid::{CONSTANTS, DECLARATION, groups},
    rig::{Options, Rig},
    twin::field_grid,
};
use glam::Vec3;
use half::f16;

/// The prepared characters, made once for all tests.
fn rigs() -> &'static [(&'static str, Rig)] {
    static RIGS: OnceLock<Vec<(&str, Rig)>> = OnceLock::new();
    RIGS.get_or_init(|| {
        let prepare = |model: &_| Rig::prepare(model, &Options::default(), &|_| {}).unwrap();
        common::characters()
            .map(|(name, model)| (name, prepare(&model)))
            .collect()
    })
}

/// Texel i of a grid: its place in rest space, and whether it lies on a face.
fn texel(field: &Field, i: usize) -> (Vec3, bool) {
    let at = [i % 32, i / 32 % 32, i / 1024];
    let face = at.iter().any(|&c| c == 0 || c == 31);
    let coordinate = Vec3::from(at.map(|c| c as f32 / 31.0));
    (field.bounds.to_rest().transform_point3(coordinate), face)
}

#[test]
fn no_field_is_cut_by_its_box() {
    for (name, rig) in rigs() {
        for field in &rig.fields {
            for i in 0..32 * 32 * 32 {
                let (x, face) = texel(field, i);
                let f = if face { field.evaluate(x).0 } else { 0.0 };
                assert!(f < 2e-3, "{} joint {}: {f}", name, field.joint);
            }
        }
    }
}

#[test]
fn vertices_lie_where_their_field_has_a_slope() {
    for (name, rig) in rigs() {
        let mut values = Vec::new();
        let mut unusable = 0;
        // Vertices that follow geometric skinning were not fitted.
        for v in (0..rig.part.len()).filter(|&v| !rig.geometric[v]) {
            let field = rig.fields.iter().find(|f| f.joint == rig.part[v]).unwrap();
            let (f, gradient) = field.evaluate(rig.mesh.positions[v]);
            values.push(f);
            let flat = gradient.length() * f64::from(field.radius) < 0.1;
            unusable += usize::from(!(0.05..0.95).contains(&f) || flat);
        }
        values.sort_by(f64::total_cmp);
        let quantile = |q: f64| values[((values.len() - 1) as f64 * q) as usize];
        let (p1, median, p99) = (quantile(0.01), quantile(0.5), quantile(0.99));
        let share = unusable as f64 / values.len() as f64;
        eprintln!(
            "{}: p1 {p1:.3} p50 {median:.3} p99 {p99:.3} unusable {share:.4}",
            name
        );
        assert!(
            p1 > 0.2 && p99 < 0.8 && (0.4..0.55).contains(&median),
            "{}",
            name
        );
        assert!(share < 0.006, "{}: {share}", name);
    }
}

#[test]
fn grids_are_their_fields_to_the_precision_of_half_floats() {
    for (name, rig) in rigs() {
        let fields = &rig.fields;
        let layout = atlas_layout(fields.len(), 2048).unwrap();
        let grids = field_grid::run(&GridInput::new(fields, layout), &CONSTANTS);
        for (field, grid) in fields.iter().zip(&grids) {
            let error =
                |i: usize| (field.evaluate(texel(field, i).0).0 - grid[i][0].to_f64()).abs();
            let worst = (0..grid.len()).map(error).fold(0.0, f64::max);
            // Half floats round by 2.4e-4 below 1. The rest is Σ λ t³ in single precision: the terms of a part with sharp
            // folds are a thousand times their sum.
            assert!(worst < 1e-3, "{} joint {}: {worst:e}", name, field.joint);
        }
    }
}

/// The atlas as the GPU samples it.
fn on_gpu(gpu: &Gpu, input: &GridInput, layout: AtlasLayout) -> Vec<[f16; 4]> {
    let buffer = |name, bytes: &[u8]| gpu.buffer_with(name, Class::Transient, bytes).unwrap();
    let fields = buffer("field_grid.fields", bytemuck::cast_slice(&input.fields));
    let centers = buffer("field_grid.centers", bytemuck::cast_slice(&input.centers));
    let segments = buffer("field_grid.segments", bytemuck::cast_slice(&input.segments));
    let atlas = gpu
        .image3d("atlas", Class::Fields, layout.extent(), Format::Rgba16F)
        .unwrap();
    let mut builder = FrameBuilder::new(gpu, "prepare");
    builder
        .pass(&DECLARATION)
        .bind("fields", &fields)
        .bind("centers", &centers)
        .bind("segments", &segments)
        .bind_image("atlas", &atlas)
        .constants(&CONSTANTS)
        .groups(groups(input.fields.len()));
    let mut frame = builder.build().unwrap();
    let start = std::time::Instant::now();
    frame.run().unwrap();
    eprintln!(
        "{} fields: {:.1} ms",
        input.fields.len(),
        start.elapsed().as_secs_f64() * 1e3
    );
    bytemuck::pod_collect_to_vec(&gpu.download_image(&atlas).unwrap())
}

/// Greatest difference of f, and of the gradient over the greatest gradient of the atlas.
fn difference(a: &[[f16; 4]], b: &[[f16; 4]]) -> [f32; 2] {
    assert_eq!(a.len(), b.len());
    let (mut value, mut slope, mut steepest) = (0.0f32, 0.0f32, 0.0f32);
    for (a, b) in a.iter().zip(b) {
        let [a, b] = [a.map(f32::from), b.map(f32::from)];
        value = value.max((a[0] - b[0]).abs());
        for c in 1..4 {
            slope = slope.max((a[c] - b[c]).abs());
            steepest = steepest.max(b[c].abs());
        }
    }
    [value, slope / steepest]
}

#[test]
fn the_gpu_samples_what_its_twin_samples() {
    let Some(gpu) = common::gpu() else { return };
    for (name, rig) in rigs() {
        let mut fields = rig.fields.clone();
        let layout = atlas_layout(fields.len(), 2048).unwrap();
        let input = GridInput::new(&fields, layout);
        let twin =
            |input: &GridInput| field_grid::atlas(&field_grid::run(input, &CONSTANTS), layout);
        let (ours, theirs) = (on_gpu(&gpu, &input, layout), twin(&input));
        assert_eq!(ours, on_gpu(&gpu, &input, layout), "two runs differ");
        // As between single and double precision above; a rounding more or less of a half float, fused or not.
        let [value, slope] = difference(&ours, &theirs);
        eprintln!("{}: value {value:e} slope {slope:e}", name);
        assert!(
            value < 1.5e-3 && slope < 4e-3,
            "{}: {value:e} {slope:e}",
            name
        );
        fields[0].hrbf.lambda[3] *= 1.1;
        let perturbed = twin(&GridInput::new(&fields, layout));
        assert!(
            difference(&ours, &perturbed)[0] > 1e-2,
            "a wrong grid must be noticed"
        );
    }
    assert!(
        gpu.validation_messages().is_empty(),
        "{:?}",
        gpu.validation_messages()
    );
}
