use super::*;
use crate::{
    Error,
    frame::FrameBuilder,
    pass::{ceiling_copy, ceiling_fetch},
};

fn budget(bytes: u64) -> GpuOptions {
    GpuOptions {
        budget: Some(bytes),
        ..Default::default()
    }
}

#[test]
fn memory_is_reported_by_class_and_name_and_returns_to_nothing() {
    let Some(gpu) = testing::gpu() else { return };
    let fields = gpu
        .image3d("fields.atlas", Class::Fields, [32, 32, 64], Format::Rgba16F)
        .unwrap();
    let mesh = gpu
        .buffer_with("mesh.positions", Class::Mesh, &[7; 1000])
        .unwrap();
    let ring = gpu.ring("poses", Class::PoseRing, 640).unwrap();
    let report = gpu.memory();
    assert!(report.classes["fields"] >= 32 * 32 * 64 * 8);
    assert!(report.classes["mesh"] >= 1000 && report.classes["pose_ring"] >= 2 * 640);
    assert_eq!(report.classes.len(), 3, "staging is gone: {report:?}");
    assert_eq!(report.total, report.classes.values().sum::<u64>());
    assert_eq!(report.names[0].name, "fields.atlas");
    assert_eq!(gpu.shared.memory.live(), 4);
    drop((fields, mesh.clone(), ring));
    assert_eq!(gpu.memory().names.len(), 1, "a clone keeps the buffer");
    drop(mesh);
    assert_eq!(gpu.memory(), MemoryReport::default());
    assert_eq!(gpu.shared.memory.live(), 0);
}

#[test]
fn a_budget_is_refused_before_allocating_naming_what_and_how_much() {
    let Some(gpu) = testing::with(&budget(1 << 20), Features::ALL) else {
        return;
    };
    let kept = gpu.buffer("kept", Class::Mesh, 600_000).unwrap();
    let refused = [
        gpu.buffer("too.much", Class::Operators, 500_000)
            .err()
            .unwrap(),
        gpu.image3d("too.much", Class::Operators, [128; 3], Format::Rgba16F)
            .err()
            .unwrap(),
        gpu.ring("too.much", Class::Operators, 300_000)
            .err()
            .unwrap(),
    ];
    for error in refused {
        let Error::Memory {
            name,
            class,
            reason,
            ..
        } = error
        else {
            panic!("{error}")
        };
        assert_eq!((&*name, class), ("too.much", "operators"));
        assert!(reason.contains("budget of 1048576 bytes"), "{reason}");
    }
    let report = gpu.memory();
    assert_eq!((report.names.len(), report.budget), (1, Some(1 << 20)));
    drop(kept);
    gpu.buffer("fits.now", Class::Operators, 500_000).unwrap();
}

#[test]
fn sizes_that_no_device_has_are_errors() {
    let Some(gpu) = testing::gpu() else { return };
    for bytes in [
        0,
        u64::from(gpu.limits().max_storage_buffer_range) + 1,
        u64::MAX,
    ] {
        assert!(matches!(
            gpu.buffer("odd", Class::Mesh, bytes),
            Err(Error::Memory { .. })
        ));
    }
    for extent in [[0, 1, 1], [1, u32::MAX, 1], [u32::MAX; 3]] {
        let image = gpu.image3d("odd", Class::Fields, extent, Format::Rgba32F);
        assert!(matches!(image, Err(Error::Memory { .. })));
    }
    let small = gpu.buffer("small", Class::Mesh, 8).unwrap();
    assert!(gpu.upload(&small, &[0; 9]).is_err());
    let image = gpu
        .image3d("image", Class::Fields, [2, 2, 2], Format::Rgba32F)
        .unwrap();
    assert!(gpu.upload_image(&image, &[0; 127]).is_err());
    let ring = gpu.ring("ring", Class::PoseRing, 8).unwrap();
    assert!(
        ring.write(Slot(0), &[0; 9]).is_err() && ring.write_at(Slot(1), u64::MAX, &[0]).is_err()
    );
}

#[test]
fn transfers_longer_than_the_staging_buffer_arrive_whole() {
    let Some(gpu) = testing::gpu() else { return };
    let bytes: Vec<u8> = (0..transfer::CHUNK as u32 / 4 * 9 / 4 + 1)
        .flat_map(u32::to_le_bytes)
        .collect();
    let buffer = gpu.buffer_with("long", Class::Mesh, &bytes).unwrap();
    assert!(gpu.download(&buffer).unwrap() == bytes);
    let extent = [64, 48, 200];
    let half = |i: u32| half::f16::from_f32((i % 1021) as f32).to_le_bytes();
    let texels: Vec<u8> = (0..64 * 48 * 200 * 4).flat_map(half).collect();
    let image = gpu
        .image3d("deep", Class::Fields, extent, Format::Rgba16F)
        .unwrap();
    gpu.upload_image(&image, &texels).unwrap();
    assert!(gpu.download_image(&image).unwrap() == texels);
}

#[test]
fn mapped_buffers_are_written_and_read_in_place() {
    let Some(gpu) = testing::gpu() else { return };
    for class in [Class::PoseRing, Class::Readback] {
        let buffer = gpu.buffer_with("mapped", class, &[1, 2, 3, 4]).unwrap();
        assert!(buffer.is_mapped());
        assert_eq!(gpu.download(&buffer).unwrap(), [1, 2, 3, 4]);
    }
    assert!(!gpu.buffer("device", Class::Mesh, 4).unwrap().is_mapped());
}

#[test]
fn handles_outlive_the_gpu_they_came_from() {
    let Some(gpu) = testing::gpu() else { return };
    let clone = Gpu::clone(&gpu);
    let buffer = gpu.buffer_with("late", Class::Mesh, &[5; 16]).unwrap();
    drop(gpu);
    assert_eq!(clone.download(&buffer).unwrap(), [5; 16]);
    drop(clone);
    assert_eq!(buffer.bytes(), 16);
}

#[test]
fn devices_are_listed_and_found_by_index_and_name() {
    let Some(gpu) = testing::gpu() else { return };
    println!("{:?}", gpu.report());
    let devices = Gpu::enumerate().unwrap();
    assert!(devices.contains(&gpu.report()));
    let open = |device| {
        Gpu::new(&GpuOptions {
            device,
            ..Default::default()
        })
    };
    let last = devices.last().unwrap();
    assert_eq!(
        open(DeviceSelector::Index(last.index)).unwrap().report(),
        *last
    );
    let name = last.name.to_uppercase();
    assert_eq!(
        open(DeviceSelector::Name(name.clone()))
            .unwrap()
            .report()
            .name
            .to_uppercase(),
        name
    );
    let missing = open(DeviceSelector::Name("no such device".into()));
    assert!(matches!(missing, Err(Error::NoDevice { .. })));
}

/// A bit of everything that makes handles or waits.
fn everything(gpu: &Gpu) -> crate::Result<()> {
    let source = gpu.buffer_with("source", Class::Mesh, &[1; 256])?;
    let atlas = gpu.image3d("atlas", Class::Fields, [32, 32, 32], Format::Rgba16F)?;
    gpu.upload_image(&atlas, &vec![0; 32 * 32 * 32 * 8])?;
    let ring = gpu.ring("ring", Class::Readback, 1024)?;
    let target = gpu.buffer("target", Class::Transient, 1024)?;
    let mut builder = FrameBuilder::new(gpu, "everything");
    builder.fill(&target, 0);
    let copy = builder.pass(&ceiling_copy::DECLARATION);
    copy.bind("source", &source)
        .bind("target", &target)
        .constants(&16u32)
        .items(16);
    let fetch = builder.pass(&ceiling_fetch::DECLARATION);
    fetch
        .bind_image("atlas", &atlas)
        .bind("sums", &target)
        .constants(&64u32)
        .items(64);
    builder.copy(&target, &ring, 1024);
    let mut frame = builder.build()?;
    let slot = frame.begin()?;
    frame.submit()?;
    frame.submit()?;
    frame.wait()?;
    ring.read(slot, &mut [0; 64])?;
    gpu.download_image(&atlas)?;
    gpu.download(&source).map(drop)
}

/// Whether the allocator has other memory to try where what the CPU writes and the device reads finds no place.
fn has_spare_memory(gpu: &Gpu) -> bool {
    use vk::MemoryPropertyFlags as Flags;
    let types = gpu.shared.physical.memory.memory_types_as_slice().iter();
    let written = Flags::HOST_VISIBLE | Flags::HOST_COHERENT;
    let suitable = types.filter(|t| t.property_flags.contains(written));
    suitable.count() > 1
}

/// Lets one call after the other fail with `code`; gives how many there were.
fn fail_each(code: vk::Result) -> u32 {
    let mut calls = 0;
    loop {
        let opened = {
            double::arm(calls, code);
            double::open()
        };
        let outcome = opened.and_then(|(gpu, canary)| {
            let outcome = everything(&gpu);
            let survived = double::disarm();
            let spare = has_spare_memory(&gpu);
            drop(gpu);
            assert_eq!(canary.messages(), Vec::<String>::new(), "call {calls}");
            assert!(
                outcome.is_ok() == survived || spare && !survived,
                "call {calls}: {outcome:?}"
            );
            outcome.map(|()| survived)
        });
        match outcome {
            Ok(true) => return calls,
            Ok(false) => {}
            Err(Error::Vulkan {
                call, code: said, ..
            }) => {
                assert!(
                    call.starts_with("vk") && said.contains(&format!("{code:?}")),
                    "{call} {said}"
                );
            }
            Err(Error::Memory { .. } | Error::NoDevice { .. }) => {}
            Err(other) => panic!("call {calls}: {other}"),
        }
        double::disarm();
        calls += 1;
    }
}

#[test]
fn whichever_call_runs_out_of_memory_or_loses_the_device_it_is_an_error_and_nothing_leaks() {
    if testing::gpu().is_none() {
        return;
    }
    let calls = fail_each(vk::Result::ERROR_OUT_OF_DEVICE_MEMORY);
    assert!(calls > 60, "{calls} calls can fail");
    assert_eq!(fail_each(vk::Result::ERROR_DEVICE_LOST), calls);
}
