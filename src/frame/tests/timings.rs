//! What timestamps tell.

use super::*;

#[test]
fn timings_cover_every_step_in_order_and_add_up() {
    let options = GpuOptions {
        profile: Profile::Full,
        ..Default::default()
    };
    let Some(gpu) = testing::with(&options, Features::ALL) else {
        return;
    };
    let (mut frame, _) = chain(&gpu);
    assert_eq!(frame.timings(), None);
    // The cost of a timestamp is a median.
    (0..15).for_each(|_| frame.run().unwrap());
    let timings = frame.timings().unwrap();
    let names: Vec<_> = timings.passes.iter().map(|p| &*p.name).collect();
    assert_eq!(names, ["fill", "add", "double", "add", "copy"]);
    let labels: Vec<_> = timings.passes.iter().map(|p| &*p.label).collect();
    assert_eq!(
        labels,
        ["fill a", "add", "double", "add.last", "copy a to c"]
    );
    let sum: u64 = timings.passes.iter().map(|p| p.nanoseconds()).sum();
    // Intervals shorter than a timestamp count as nothing.
    assert!(timings.gpu_ns > 0 && sum >= timings.gpu_ns);
    assert!(sum <= timings.gpu_ns + 5 * timings.stamp_ns);
    assert!(timings.cpu_record_ns > 0 && timings.cpu_record_ns == frame.cpu_record_ns());
    frame.set_profile(Profile::Off);
    (0..2).for_each(|_| frame.run().unwrap());
    let first = timings.passes[0].begin_ns;
    assert_eq!(
        frame.timings().unwrap().passes[0].begin_ns,
        first,
        "the last that was timed"
    );
}

/// Six rounds of two passes, then a run of three fills.
fn rounds(gpu: &Gpu) -> Frame {
    let [a, b] = ["a", "b"].map(|name| buffer(gpu, name));
    let mut builder = FrameBuilder::new(gpu, "rounds");
    for _ in 0..6 {
        add(&mut builder, &a, &b, 3);
        builder.pass(&DOUBLE).bind("values", &b).items(COUNT);
    }
    (0..3).for_each(|value| builder.fill(&a, value));
    builder.build().unwrap()
}

#[test]
fn sampled_timings_have_all_steps_of_a_name_or_none_and_every_name_in_its_turn() {
    let options = GpuOptions {
        profile: Profile::Sampled,
        ..Default::default()
    };
    let Some(gpu) = testing::with(&options, Features::ALL) else {
        return;
    };
    let mut frame = rounds(&gpu);
    let mut seen = std::collections::BTreeMap::new();
    frame.run().unwrap();
    let turns = frame.timings().unwrap().turns;
    for _ in 0..2 * turns {
        frame.run().unwrap();
        let timings = frame.timings().unwrap();
        let sum: u64 = timings.passes.iter().map(|p| p.nanoseconds()).sum();
        let stamps = 2 * timings.passes.len() as u64 + 1;
        assert!(sum <= timings.gpu_ns + stamps * timings.stamp_ns);
        for (name, steps, _) in timings.by_name() {
            assert_eq!(steps, if name == "fill" { 3 } else { 6 });
            *seen.entry(name.to_string()).or_insert(0) += 1;
        }
        let fills = timings.passes.iter().filter(|p| p.name == "fill");
        assert!(fills.count() <= 1, "a run is timed as one");
    }
    let names: Vec<_> = seen.iter().map(|(n, count)| (&**n, *count)).collect();
    assert_eq!(names, [("add", 2), ("double", 2), ("fill", 2)]);
    gpu.set_profile(Profile::Full);
    frame.run().unwrap();
    let timings = frame.timings().unwrap();
    assert_eq!((timings.turns, timings.passes.len()), (1, 15));
}

#[test]
fn timings_are_there_while_the_next_frames_are_in_flight() {
    let options = GpuOptions {
        profile: Profile::Full,
        ..Default::default()
    };
    let Some(gpu) = testing::with(&options, Features::ALL) else {
        return;
    };
    let (mut frame, _) = chain(&gpu);
    for submission in 0..6 {
        frame.submit().unwrap();
        assert!(submission < 2 || frame.timings().is_some());
    }
}

#[test]
fn the_device_clock_is_that_of_the_timestamps() {
    let options = GpuOptions {
        profile: Profile::Full,
        ..Default::default()
    };
    let Some(gpu) = testing::with(&options, Features::ALL) else {
        return;
    };
    let Some((before, _)) = gpu.clock() else {
        return;
    };
    let (mut frame, _) = chain(&gpu);
    frame.run().unwrap();
    let after = gpu.clock().unwrap().0;
    for pass in frame.timings().unwrap().passes {
        assert!(before <= pass.begin_ns && pass.end_ns <= after);
    }
}
