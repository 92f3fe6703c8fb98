//! Steps that are recorded once.

use std::ops::Range;

use super::*;
use crate::gpu::Ring;

/// b = ring + 1; b *= 2; then a = b + index; a *= 2; copy a → c; copy c → back. Gives both rings.
fn halves(gpu: &Gpu, sections: &[Range<usize>]) -> (Frame, [Ring; 2]) {
    let [a, b, c] = ["a", "b", "c"].map(|name| buffer(gpu, name));
    let ring = |name, class| gpu.ring(name, class, a.bytes()).unwrap();
    let rings = [ring("ring", Class::PoseRing), ring("back", Class::Readback)];
    let mut builder = FrameBuilder::new(gpu, "halves");
    builder
        .pass(&ADD)
        .bind_ring("source", &rings[0])
        .bind("target", &b)
        .constants(&[COUNT, 1])
        .items(COUNT);
    builder.pass(&DOUBLE).bind("values", &b).items(COUNT);
    add(&mut builder, &b, &a, 0).index_at(4);
    builder.pass(&DOUBLE).bind("values", &a).items(COUNT);
    builder.copy(&a, &c, a.bytes());
    builder.copy(&c, &rings[1], c.bytes());
    sections.iter().cloned().for_each(|s| builder.fix(s));
    (builder.build().unwrap(), rings)
}

/// All steps of [`halves`].
const ALL: Range<usize> = 0..6;

fn runs(frame: &Frame) -> Vec<Range<usize>> {
    frame.fixed.iter().map(|run| run.steps.clone()).collect()
}

fn span(steps: Range<usize>, index: u32) -> Span {
    Span { steps, index }
}

/// The first word that comes back where every word of the ring is `value`.
fn play(frame: &mut Frame, rings: &[Ring; 2], value: u32, spans: &[Span]) -> u32 {
    let slot = frame.begin().unwrap();
    let mut words = vec![value; COUNT as usize];
    rings[0].write(slot, bytemuck::cast_slice(&words)).unwrap();
    frame.submit_spans(spans).unwrap();
    frame.wait().unwrap();
    rings[1]
        .read(slot, bytemuck::cast_slice_mut(&mut words))
        .unwrap();
    assert!(words.iter().all(|w| *w == words[0]));
    words[0]
}

#[test]
fn runs_are_what_depends_on_neither_slot_nor_index_and_end_with_their_section() {
    let Some(gpu) = testing::gpu() else { return };
    let of = |sections: &[Range<usize>]| runs(&halves(&gpu, sections).0);
    assert_eq!(of(&[]), []);
    assert_eq!(of(&[0..4, 4..6]), [1..2, 3..4, 4..5]);
    assert_eq!(of(&[ALL]), [1..2, 3..5]);
    assert_eq!(of(&[0..1, 5..6]), []);
    let mut builder = FrameBuilder::new(&gpu, "beyond");
    builder.fix(0..1);
    let error = builder.build().err().unwrap().to_string();
    assert!(error.contains("0..1 of 0"), "{error}");
}

#[test]
fn fixed_steps_do_the_same_as_often_as_they_are_executed() {
    let Some(gpu) = testing::gpu() else { return };
    let once = [span(0..2, 0), span(2..6, 7)];
    // Through whole runs several times, and through a part of one.
    let often = [&once[..], &[span(3..5, 0), span(3..4, 0), span(4..6, 0)]].concat();
    for sections in [&[][..], &[0..2, 2..6]] {
        let (mut frame, rings) = halves(&gpu, sections);
        for value in 0..4 {
            let expected = 2 * (2 * (value + 1) + 7);
            assert_eq!(play(&mut frame, &rings, value, &once), expected);
            assert_eq!(play(&mut frame, &rings, value, &often), 4 * expected);
        }
    }
}

#[test]
fn fixed_frames_are_timed_step_by_step() {
    let Some(gpu) = testing::gpu() else { return };
    let (mut frame, rings) = halves(&gpu, &[ALL]);
    let all = [span(ALL, 7)];
    for profile in [Profile::Full, Profile::Off] {
        frame.set_profile(profile);
        assert_eq!(play(&mut frame, &rings, 1, &all), 22);
    }
    if gpu.features().timestamps {
        assert_eq!(frame.timings().unwrap().passes.len(), 6);
    }
}

#[test]
fn what_is_fixed_changes_no_more() {
    let Some(gpu) = testing::gpu() else { return };
    let (mut frame, _) = halves(&gpu, &[ALL]);
    frame.set_constants(0, &[COUNT, 2]).unwrap();
    let error = frame.set_items(1, COUNT).unwrap_err().to_string();
    assert!(error.contains("that may change"), "{error}");
}
