//! A steady frame allocates nothing on the CPU: not in `begin`, not in `submit`, not in `wait`.

#[path = "common/allocations.rs"]
mod allocations;

use dermis::{
    frame::FrameBuilder,
    gpu::{Class, Gpu, GpuOptions, Profile},
    pass::ceiling_copy,
};

#[test]
fn a_steady_frame_allocates_nothing() -> dermis::Result<()> {
    if std::env::var("DERMIS_NO_GPU").is_ok_and(|v| v == "1") {
        return Ok(());
    }
    let options = GpuOptions {
        profile: Profile::Full,
        ..Default::default()
    };
    let gpu = Gpu::new(&options)?;
    for profile in [Profile::Full, Profile::Sampled, Profile::Off] {
        gpu.set_profile(profile);
        steady(&gpu)?;
    }
    allocations::are_counted();
    Ok(())
}

fn steady(gpu: &Gpu) -> dermis::Result<()> {
    let ring = gpu.ring("ring", Class::PoseRing, 1024)?;
    let target = gpu.buffer("target", Class::Transient, 1024)?;
    let mut builder = FrameBuilder::new(gpu, "steady");
    for _ in 0..8 {
        builder.fill(&target, 1);
        let copy = builder.pass(&ceiling_copy::DECLARATION);
        copy.bind_ring("source", &ring)
            .bind("target", &target)
            .constants(&64u32)
            .items(64);
    }
    let mut frame = builder.build()?;
    let mut record = Vec::with_capacity(100);
    for submission in 0..100 {
        let before = allocations::so_far();
        let slot = frame.begin()?;
        ring.write(slot, &[1; 1024])?;
        frame.submit()?;
        if submission % 3 == 0 {
            frame.wait()?;
        }
        let allocated = allocations::so_far() - before;
        assert!(
            submission < 3 || allocated == 0,
            "submission {submission}: {allocated} allocations"
        );
        record.push(frame.cpu_record_ns());
    }
    record.sort_unstable();
    println!(
        "{}: 16 steps recorded in {} ns at the median",
        gpu.report().name,
        record[50]
    );
    Ok(())
}
