//! What timing a pass adds to the time of the pass, measured on a frame whose true time is known.

use super::{Frame, FrameBuilder};
use crate::{
    Result,
    gpu::{Class, Gpu, Profile},
    pass::{ceiling_copy, ceiling_fetch},
    report::FrameTimings,
};

/// Dispatches of either pass in the frame.
const PAIRS: usize = 16;
/// Invocations of a dispatch: little work, so that its surroundings show.
const COUNT: u32 = 64;

/// Measures how much longer a dispatch takes between two timestamps than without them.
///
/// The interval between two timestamps with nothing in it, which all timings leave out, is not all that timing costs: a
/// software device also wakes its threads and sets up its state anew after a timestamp. So a frame of small dispatches
/// plays with and without timestamps around them; the difference, a dispatch, is the excess.
pub struct StampMeter {
    frame: Frame,
}

impl StampMeter {
    /// Makes the frame; a few kilobytes of transient memory.
    ///
    /// # Errors
    /// As [`super::CeilingMeter::new`].
    pub fn new(gpu: &Gpu) -> Result<Self> {
        let image = gpu.image3d(
            "stamp.atlas",
            Class::Transient,
            [32; 3],
            crate::gpu::Format::Rgba16F,
        )?;
        let bytes = u64::from(COUNT) * 16;
        let source = gpu.buffer("stamp.source", Class::Transient, bytes)?;
        let target = gpu.buffer("stamp.target", Class::Transient, bytes)?;
        let mut builder = FrameBuilder::new(gpu, "stamp");
        for _ in 0..PAIRS {
            builder
                .pass(&ceiling_copy::DECLARATION)
                .bind("source", &source)
                .bind("target", &target)
                .constants(&COUNT)
                .items(COUNT);
            builder
                .pass(&ceiling_fetch::DECLARATION)
                .bind_image("atlas", &image)
                .bind("sums", &target)
                .constants(&COUNT)
                .items(COUNT);
        }
        let mut frame = builder.build()?;
        frame.set_profile(Profile::Sampled);
        let mut meter = Self { frame };
        // Shaders are compiled at their first dispatch.
        meter.measure()?;
        Ok(meter)
    }

    /// One measurement: nanoseconds that a timed dispatch takes longer; 0 where there are no timestamps.
    ///
    /// # Errors
    /// [`Error::Vulkan`](crate::Error::Vulkan) where the driver fails.
    pub fn measure(&mut self) -> Result<u64> {
        let (mut timed, mut whole) = (0, u64::MAX);
        let mut turn = 0;
        loop {
            self.frame.run()?;
            let Some(timings) = self.frame.timings() else {
                return Ok(0);
            };
            if timings.passes.is_empty() {
                whole = whole.min(timings.gpu_ns);
            }
            timed += interval_ns(&timings);
            turn += 1;
            if turn >= timings.turns {
                break;
            }
        }
        let dispatches = 2 * PAIRS as u64;
        Ok(if whole == u64::MAX {
            0
        } else {
            timed.saturating_sub(whole) / dispatches
        })
    }
}

fn interval_ns(timings: &FrameTimings) -> u64 {
    let intervals = timings.passes.iter().map(|p| p.end_ns - p.begin_ns);
    intervals.sum()
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::gpu::testing;

    #[test]
    fn the_excess_is_finite_and_every_turn_is_played() {
        let Some(gpu) = testing::gpu() else { return };
        let mut meter = StampMeter::new(&gpu).unwrap();
        let excess = meter.measure().unwrap();
        println!("{}: {excess} ns a timed dispatch", gpu.report().name);
        assert!(excess < 1_000_000_000);
        let again = meter.frame.timings().unwrap();
        assert!(
            again.turns > 2,
            "both passes have a turn, and some have none"
        );
        assert!(again.passes.len() <= PAIRS);
    }

    #[test]
    fn meters_leave_no_memory() {
        let Some(gpu) = testing::gpu() else { return };
        drop(StampMeter::new(&gpu).unwrap());
        assert_eq!(gpu.memory().total, 0);
    }
}
