use super::*;
use crate::gpu::{
    Access, Binding, Class, Declaration, Features, Format, GpuOptions, Profile, testing,
    testing::TestGpu,
};

mod fixed;
mod timings;

const ADD: Declaration = Declaration {
    name: "add",
    spirv: include_bytes!("../gpu/testdata/add.spv"),
    bindings: &[
        Binding {
            name: "source",
            access: Access::Read,
        },
        Binding {
            name: "target",
            access: Access::Write,
        },
    ],
    constants: 8,
    local_size: [64, 1, 1],
};

const DOUBLE: Declaration = Declaration {
    name: "double",
    spirv: include_bytes!("../gpu/testdata/double.spv"),
    bindings: &[Binding {
        name: "values",
        access: Access::ReadWrite,
    }],
    constants: 0,
    local_size: [64, 1, 1],
};

const EXTENT: Declaration = Declaration {
    name: "extent",
    spirv: include_bytes!("../gpu/testdata/extent.spv"),
    bindings: &[
        Binding {
            name: "wanted",
            access: Access::Uniform,
        },
        Binding {
            name: "counts",
            access: Access::Write,
        },
    ],
    constants: 0,
    local_size: [1, 1, 1],
};

const PAINT: Declaration = Declaration {
    name: "paint",
    spirv: include_bytes!("../gpu/testdata/paint.spv"),
    bindings: &[Binding {
        name: "volume",
        access: Access::ImageWrite,
    }],
    constants: 0,
    local_size: [4, 4, 4],
};

const SAMPLE: Declaration = Declaration {
    name: "sample",
    spirv: include_bytes!("../gpu/testdata/sample.spv"),
    bindings: &[
        Binding {
            name: "volume",
            access: Access::Sampled,
        },
        Binding {
            name: "samples",
            access: Access::Write,
        },
    ],
    constants: 0,
    local_size: [8, 1, 1],
};

const COUNT: u32 = 1000;

fn buffer(gpu: &Gpu, name: &str) -> crate::gpu::Buffer {
    gpu.buffer(name, Class::Transient, u64::from(COUNT) * 4)
        .unwrap()
}

/// target = source + constant.
fn add<'a>(
    builder: &'a mut FrameBuilder,
    source: &crate::gpu::Buffer,
    target: &crate::gpu::Buffer,
    constant: u32,
) -> PassBuilder<'a> {
    let pass = builder.pass(&ADD);
    let bound = pass.bind("source", source).bind("target", target);
    bound.constants(&[COUNT, constant]).items(COUNT)
}

fn words(gpu: &Gpu, buffer: &crate::gpu::Buffer) -> Vec<u32> {
    bytemuck::pod_collect_to_vec(&gpu.download(buffer).unwrap())
}

/// fill 5 → a; b = a + 3; b *= 2; a = b + 1; copy a → c. Every kind of hazard but indirect.
fn chain(gpu: &Gpu) -> (Frame, crate::gpu::Buffer) {
    let [a, b, c] = ["a", "b", "c"].map(|name| buffer(gpu, name));
    let mut builder = FrameBuilder::new(gpu, "chain");
    builder.fill(&a, 5);
    add(&mut builder, &a, &b, 3);
    builder.pass(&DOUBLE).bind("values", &b).items(COUNT);
    add(&mut builder, &b, &a, 1).label("add.last");
    builder.copy(&a, &c, a.bytes());
    (builder.build().unwrap(), c)
}

fn check_chain(gpu: &TestGpu) {
    let (mut frame, result) = chain(gpu);
    for _ in 0..5 {
        frame.submit().unwrap();
    }
    frame.wait().unwrap();
    assert_eq!(words(gpu, &result), vec![17; COUNT as usize]);
}

#[test]
fn a_chain_of_all_hazards_computes_right_and_validation_is_silent() {
    let Some(gpu) = testing::gpu() else { return };
    assert!(
        gpu.features().synchronization2,
        "lavapipe and all current drivers have it"
    );
    check_chain(&gpu);
}

#[test]
fn the_same_chain_runs_without_any_optional_feature() {
    let options = GpuOptions {
        profile: Profile::Full,
        ..Default::default()
    };
    let Some(gpu) = testing::with(&options, Features::NONE) else {
        return;
    };
    assert_eq!(gpu.features(), Features::NONE);
    check_chain(&gpu);
    let (mut frame, _) = chain(&gpu);
    frame.run().unwrap();
    assert_eq!(frame.timings(), None);
    assert!(gpu.clock().is_none());
}

#[test]
fn synchronization_validation_catches_a_barrier_left_out() {
    let Some(gpu) = testing::gpu() else { return };
    let (mut frame, _) = chain(&gpu);
    // Without its accesses the executor believes that the last pass touches nothing. (Of two writes in a row the layers
    // say nothing where shaders make them; those are for the tests of the derivation.)
    frame.program.steps[3].uses = 0..0;
    frame.run().unwrap();
    let messages = gpu.take_messages();
    assert!(
        messages.iter().any(|m| m.contains("SYNC-HAZARD")),
        "{messages:?}"
    );
}

#[test]
fn indirect_counts_written_in_the_same_frame_are_seen() {
    let Some(gpu) = testing::gpu() else { return };
    let wanted = gpu.ring("wanted", Class::PoseRing, 4).unwrap();
    let counts = gpu.buffer("counts", Class::Transient, 16).unwrap();
    let [source, target] = ["source", "target"].map(|name| buffer(&gpu, name));
    let mut builder = FrameBuilder::new(&gpu, "indirect");
    builder.fill(&source, 1);
    builder.fill(&target, 0);
    builder
        .pass(&EXTENT)
        .bind_ring("wanted", &wanted)
        .bind("counts", &counts)
        .groups([1, 1, 1]);
    builder
        .pass(&ADD)
        .bind("source", &source)
        .bind("target", &target)
        .constants(&[COUNT, 1])
        .indirect(&counts, 0);
    let mut frame = builder.build().unwrap();
    for groups in [2u32, 0, 5, 3] {
        let slot = frame.begin().unwrap();
        wanted.write(slot, bytemuck::bytes_of(&groups)).unwrap();
        frame.submit().unwrap();
        let sum: u32 = words(&gpu, &target).iter().sum();
        assert_eq!(sum, 2 * 64 * groups);
    }
}

#[test]
fn a_volume_is_painted_sampled_and_downloaded() {
    let Some(gpu) = testing::gpu() else { return };
    let volume = gpu
        .image3d("volume", Class::Fields, [8, 4, 4], Format::Rgba16F)
        .unwrap();
    let samples = gpu.buffer("samples", Class::Transient, 8 * 16).unwrap();
    let mut builder = FrameBuilder::new(&gpu, "volume");
    builder
        .pass(&PAINT)
        .bind_image("volume", &volume)
        .groups([2, 1, 1]);
    builder
        .pass(&SAMPLE)
        .bind_image("volume", &volume)
        .bind("samples", &samples)
        .items(8);
    builder.build().unwrap().run().unwrap();
    let samples: Vec<[f32; 4]> = bytemuck::pod_collect_to_vec(&gpu.download(&samples).unwrap());
    for (i, sample) in samples.iter().enumerate() {
        // Half way to the next texel; the last is clamped to the edge.
        let x = (i as f32 + 0.5).min(7.0);
        assert_eq!(*sample, [x, 1.0, 2.0, 1.0]);
    }
    let texels: Vec<[half::f16; 4]> =
        bytemuck::pod_collect_to_vec(&gpu.download_image(&volume).unwrap());
    let last = texels[8 * 4 * 4 - 1].map(half::f16::to_f32);
    assert_eq!(last, [7.0, 3.0, 3.0, 1.0]);
}

#[test]
fn rings_keep_the_frames_in_flight_apart() {
    let Some(gpu) = testing::gpu() else { return };
    let ring = gpu
        .ring("ring", Class::PoseRing, u64::from(COUNT) * 4)
        .unwrap();
    let back = gpu
        .ring("back", Class::Readback, u64::from(COUNT) * 4)
        .unwrap();
    let target = buffer(&gpu, "target");
    let mut builder = FrameBuilder::new(&gpu, "rings");
    builder
        .pass(&ADD)
        .bind_ring("source", &ring)
        .bind("target", &target)
        .constants(&[COUNT, 1])
        .items(COUNT);
    builder.copy(&target, &back, target.bytes());
    let mut frame = builder.build().unwrap();
    let mut before = None;
    let mut found = vec![0u32; COUNT as usize];
    for value in 0..20u32 {
        let slot = frame.begin().unwrap();
        ring.write(slot, bytemuck::cast_slice(&vec![value; COUNT as usize]))
            .unwrap();
        frame.submit().unwrap();
        if let Some((slot, value)) = before.replace((slot, value)) {
            // The frame before may still run; waiting for the next begin is what frees it, so wait for all here.
            frame.wait().unwrap();
            back.read(slot, bytemuck::cast_slice_mut(&mut found))
                .unwrap();
            assert!(found.iter().all(|f| *f == value + 1), "{value}");
        }
    }
}

#[test]
fn spans_repeat_steps_with_their_index() {
    let Some(gpu) = testing::gpu() else { return };
    let [a, b] = ["a", "b"].map(|name| buffer(&gpu, name));
    let mut builder = FrameBuilder::new(&gpu, "spans");
    builder.fill(&a, 0);
    let first = builder.steps();
    add(&mut builder, &a, &b, 0).index_at(4);
    builder.copy(&b, &a, a.bytes());
    let last = builder.steps();
    let mut frame = builder.build().unwrap();
    let mut spans = vec![Span {
        steps: 0..first,
        index: 0,
    }];
    spans.extend((1..=4).map(|index| Span {
        steps: first..last,
        index,
    }));
    frame.submit_spans(&spans).unwrap();
    assert_eq!(words(&gpu, &a), vec![1 + 2 + 3 + 4; COUNT as usize]);
    let beyond = Span {
        steps: 0..last + 1,
        index: 0,
    };
    assert!(matches!(
        frame.submit_spans(&[beyond]),
        Err(Error::Argument { .. })
    ));
}

#[test]
fn constants_and_items_change_between_submissions() {
    let Some(gpu) = testing::gpu() else { return };
    let [a, b] = ["a", "b"].map(|name| buffer(&gpu, name));
    let mut builder = FrameBuilder::new(&gpu, "changes");
    builder.fill(&a, 7);
    builder.fill(&b, 0);
    let add = add(&mut builder, &a, &b, 1).step();
    let mut frame = builder.build().unwrap();
    frame.set_constants(add, &[COUNT, 2]).unwrap();
    frame.set_items(add, 64).unwrap();
    frame.run().unwrap();
    let found = words(&gpu, &b);
    assert!(found[..64].iter().all(|f| *f == 9) && found[64..].iter().all(|f| *f == 0));
    assert!(frame.set_constants(add, &1u32).is_err() && frame.set_items(0, 1).is_err());
    assert!(
        frame.set_items(add, u32::MAX).is_err()
            || gpu.limits().max_compute_work_group_count[0] >= 1 << 26
    );
}

/// The error of a frame with one `ADD` that `complete` completes.
fn refusal(gpu: &Gpu, complete: impl for<'a> FnOnce(PassBuilder<'a>) -> PassBuilder<'a>) -> String {
    let mut builder = FrameBuilder::new(gpu, "wrong");
    complete(builder.pass(&ADD));
    builder.build().err().unwrap().to_string()
}

#[test]
fn every_incomplete_or_wrong_pass_is_refused_by_name() {
    let Some(gpu) = testing::gpu() else { return };
    let [a, b] = ["a", "b"].map(|name| buffer(&gpu, name));
    let volume = gpu
        .image3d("volume", Class::Fields, [4, 4, 4], Format::Rgba32F)
        .unwrap();
    let constants = [COUNT, 1];
    let unbound = refusal(&gpu, |p| {
        p.bind("source", &a).constants(&constants).items(1)
    });
    assert!(
        unbound.contains("pass add") && unbound.contains("\"target\" is not bound"),
        "{unbound}"
    );
    let unknown = refusal(&gpu, |p| p.bind("sauce", &a));
    assert!(unknown.contains("no binding \"sauce\""), "{unknown}");
    let twice = refusal(&gpu, |p| p.bind("source", &a).bind("source", &b));
    assert!(twice.contains("bound twice"), "{twice}");
    let image = refusal(&gpu, |p| p.bind_image("source", &volume));
    assert!(image.contains("volume is an image"), "{image}");
    let none = refusal(&gpu, |p| p.bind("source", &a).bind("target", &b).items(1));
    assert!(
        none.contains("0 bytes of push constants are given, 8 declared"),
        "{none}"
    );
    let extent = refusal(&gpu, |p| {
        p.bind("source", &a)
            .bind("target", &b)
            .constants(&constants)
    });
    assert!(extent.contains("no extent"), "{extent}");
    let indirect = refusal(&gpu, |p| p.indirect(&a, a.bytes() - 8));
    assert!(indirect.contains("no three counts"), "{indirect}");
    let index = refusal(&gpu, |p| {
        p.bind("source", &a)
            .bind("target", &b)
            .constants(&constants)
            .items(1)
            .index_at(8)
    });
    assert!(index.contains("no word at byte 8"), "{index}");
}

#[test]
fn wrong_copies_formats_and_devices_are_refused() {
    let Some(gpu) = testing::gpu() else { return };
    let [a, b] = ["a", "b"].map(|name| buffer(&gpu, name));
    let mut builder = FrameBuilder::new(&gpu, "copy");
    builder.copy(&a, &b, a.bytes() + 1);
    assert!(builder.build().is_err());
    let wide = gpu
        .image3d("wide", Class::Fields, [4, 4, 4], Format::Rgba32F)
        .unwrap();
    let mut builder = FrameBuilder::new(&gpu, "format");
    builder
        .pass(&PAINT)
        .bind_image("volume", &wide)
        .groups([1, 1, 1]);
    let error = builder.build().err().unwrap().to_string();
    assert!(error.contains("wide is Rgba32F"), "{error}");
    let Some(other) = testing::gpu() else { return };
    let mut builder = FrameBuilder::new(&other, "foreign");
    builder.fill(&a, 0);
    let error = builder.build().err().unwrap().to_string();
    assert!(error.contains("another device"), "{error}");
}

#[test]
fn dropping_everything_in_flight_is_safe() {
    let Some(gpu) = testing::gpu() else { return };
    let (mut frame, result) = chain(&gpu);
    frame.submit().unwrap();
    frame.submit().unwrap();
    drop((frame, result));
    gpu.wait().unwrap();
    assert_eq!(gpu.memory().total, 0);
    assert_eq!(gpu.shared.memory.live(), 0);
}
