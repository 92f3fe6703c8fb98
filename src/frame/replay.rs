//! What a device can do at best where a projection takes its samples.

use super::{Frame, FrameBuilder, ceiling::seconds};
use crate::{
    Error, Result,
    gpu::{Buffer, Class, Format, Gpu, Image3d},
    pass::ceiling_replay::{Constants, DECLARATION, SAMPLES},
};

/// Least number of places.
pub const LEAST_PLACES: usize = SAMPLES as usize;

/// Measures the rate of samples at given places of an atlas, with nothing else to do.
///
/// [`super::CeilingMeter`] walks evenly through tiles, so that samples share texels, as they do at best. A projection's do
/// not: it samples the shell of every part once or twice a round, most of it from outside the caches. This is its own
/// ceiling.
pub struct ReplayMeter {
    frame: Frame,
    samples: u64,
}

impl ReplayMeter {
    /// Uploads an atlas of half-float RGBA texels, x fastest, and the places, which are texture coordinates; each place is
    /// sampled `repeats` times.
    ///
    /// # Errors
    /// [`Error::Argument`] for less than [`LEAST_PLACES`]; [`Error::Memory`] where the budget has no room; [`Error::Vulkan`]
    /// where the driver fails.
    pub fn new(
        gpu: &Gpu,
        extent: [u32; 3],
        texels: &[u8],
        places: &[[f32; 4]],
        repeats: u32,
    ) -> Result<Self> {
        let constants = Constants {
            count: places.len() as u32 / SAMPLES,
            repeats,
        };
        if constants.count == 0 {
            let reason = format!("{} places; at least {SAMPLES} are needed", places.len());
            return Err(Error::argument("replay", reason));
        }
        let atlas = gpu.image3d("replay.atlas", Class::Transient, extent, Format::Rgba16F)?;
        gpu.upload_image(&atlas, texels)?;
        let places = gpu.buffer_with(
            "replay.places",
            Class::Transient,
            bytemuck::cast_slice(places),
        )?;
        let bytes = u64::from(constants.count) * 16;
        let sums = gpu.buffer("replay.sums", Class::Transient, bytes)?;
        let mut meter = Self {
            frame: replay(gpu, &atlas, &places, &sums, &constants)?,
            samples: u64::from(constants.count * SAMPLES * repeats),
        };
        // Shaders are compiled at their first dispatch.
        meter.measure()?;
        Ok(meter)
    }

    /// One measurement: samples a second.
    ///
    /// # Errors
    /// [`Error::Vulkan`] where the driver fails.
    pub fn measure(&mut self) -> Result<f64> {
        Ok(self.samples as f64 / seconds(&mut self.frame)?)
    }
}

fn replay(
    gpu: &Gpu,
    atlas: &Image3d,
    places: &Buffer,
    sums: &Buffer,
    constants: &Constants,
) -> Result<Frame> {
    let mut builder = FrameBuilder::new(gpu, "ceiling_replay");
    builder
        .pass(&DECLARATION)
        .bind("places", places)
        .bind_image("atlas", atlas)
        .bind("sums", sums)
        .constants(constants)
        .items(constants.count);
    builder.build()
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::{gpu::testing, twin};
    use half::f16;

    /// An atlas of 8 × 4 × 4 texels and 40 places in it.
    fn scene() -> (twin::Image, Vec<[f32; 4]>) {
        let value = |i: u32| f16::from_f32((i as f32 * 0.7).sin());
        let image = twin::Image {
            extent: [8, 4, 4],
            texels: (0..128)
                .map(|i| [0, 1, 2, 3].map(|c| value(4 * i + c)))
                .collect(),
        };
        // Texture coordinates in quarters of a texel, which every filter has exactly.
        let place = |i: u32| {
            let at = [i % 29, i * 7 % 13, i * 5 % 13].map(|x| x as f32 * 0.25 + 0.5);
            [at[0] / 8.0, at[1] / 4.0, at[2] / 4.0, 0.0]
        };
        (image, (0..40).map(place).collect())
    }

    #[test]
    fn replay_agrees_with_its_twin() {
        let Some(gpu) = testing::gpu() else { return };
        let (mut image, places) = scene();
        let atlas = gpu
            .image3d("atlas", Class::Transient, image.extent, Format::Rgba16F)
            .unwrap();
        gpu.upload_image(&atlas, bytemuck::cast_slice(&image.texels))
            .unwrap();
        let buffer = gpu
            .buffer_with("places", Class::Transient, bytemuck::cast_slice(&places))
            .unwrap();
        let sums = gpu.buffer("sums", Class::Transient, 160).unwrap();
        let constants = Constants {
            count: 10,
            repeats: 2,
        };
        replay(&gpu, &atlas, &buffer, &sums, &constants)
            .unwrap()
            .run()
            .unwrap();
        let device: Vec<[f32; 4]> = bytemuck::pod_collect_to_vec(&gpu.download(&sums).unwrap());
        let difference = |image: &twin::Image| {
            let twin = twin::ceiling_replay(image, &places, 2);
            let pairs = device.iter().flatten().zip(twin.iter().flatten());
            pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f32::max)
        };
        // Eight samples of size 1, in filters that err by half a step of half floats.
        let tolerance = 8.0 / 4096.0;
        assert!(difference(&image) <= tolerance, "{}", difference(&image));
        image.texels[40][2] = f16::from_f32(3.0);
        assert!(difference(&image) > tolerance);
    }

    #[test]
    fn a_meter_measures_and_refuses_too_few_places() {
        let Some(gpu) = testing::gpu() else { return };
        let (image, places) = scene();
        let texels = bytemuck::cast_slice(&image.texels);
        let mut meter = ReplayMeter::new(&gpu, image.extent, texels, &places, 2).unwrap();
        assert!(meter.measure().unwrap() > 0.0);
        assert!(ReplayMeter::new(&gpu, image.extent, texels, &places[..3], 2).is_err());
        drop(meter);
        assert_eq!(gpu.memory().total, 0);
    }
}
