//! What the device can do at best, measured in the same run as everything else.

use std::time::Instant;

use half::f16;

use super::{Frame, FrameBuilder};
use crate::{
    Result,
    gpu::{Buffer, Class, Format, Gpu, Image3d, Profile},
    pass::{ceiling_copy, ceiling_fetch},
    report::Ceiling,
};

/// Texels an edge of a tile, as fields have.
const TILE: u32 = 32;
/// Tiles of the atlas, as many as a character has bones.
const TILES: u32 = 32;
/// Invocations of one dispatch: the vertices of a large character, eight times over.
const COUNT: u32 = 1 << 18;
/// Measurements, of which the best counts; machines are shared.
const RUNS: usize = 9;

/// Measures what a device can do at best, again and again beside what is to be compared with it.
///
/// The samples are those of a projection: from one half-float RGBA image of 32³ tiles above each other, lanes a texel
/// apart.
pub struct CeilingMeter {
    fetch: Frame,
    copy: Frame,
}

impl CeilingMeter {
    /// Makes the kernels and their buffers: some 16 MB of transient memory.
    ///
    /// # Errors
    /// [`Error::Memory`](crate::Error::Memory) where the budget has no room; [`Error::Vulkan`](crate::Error::Vulkan)
    /// where the driver fails.
    pub fn new(gpu: &Gpu) -> Result<Self> {
        let extent = extent(gpu.limits().max_image_dimension3_d);
        let atlas = gpu.image3d("ceiling.atlas", Class::Transient, extent, Format::Rgba16F)?;
        gpu.upload_image(&atlas, bytemuck::cast_slice(&texels(extent)))?;
        let target = gpu.buffer("ceiling.target", Class::Transient, u64::from(COUNT) * 16)?;
        let source = vec![1.0f32; COUNT as usize * 4];
        let source = gpu.buffer_with(
            "ceiling.source",
            Class::Transient,
            bytemuck::cast_slice(&source),
        )?;
        let mut meter = Self {
            fetch: fetch(gpu, &atlas, &target, COUNT)?,
            copy: copy(gpu, &source, &target, COUNT)?,
        };
        // Shaders are compiled at their first dispatch.
        meter.measure()?;
        Ok(meter)
    }

    /// One measurement.
    ///
    /// # Errors
    /// [`Error::Vulkan`](crate::Error::Vulkan) where the driver fails.
    pub fn measure(&mut self) -> Result<Ceiling> {
        Ok(Ceiling {
            fetch3d_per_s: f64::from(COUNT * ceiling_fetch::SAMPLES) / seconds(&mut self.fetch)?,
            copy_bytes_per_s: f64::from(COUNT) * 32.0 / seconds(&mut self.copy)?,
            replay3d_per_s: 0.0,
        })
    }
}

impl Gpu {
    /// Measures the rate of filtered 3D samples and of copies, the best of nine.
    ///
    /// # Errors
    /// As [`CeilingMeter::new`].
    pub fn measure_ceiling(&self) -> Result<Ceiling> {
        let mut meter = CeilingMeter::new(self)?;
        (0..RUNS).try_fold(Ceiling::default(), |best, _| Ok(best.max(meter.measure()?)))
    }
}

/// Tiles above each other in y, as far as the device's images reach, then in z.
fn extent(most: u32) -> [u32; 3] {
    let high = (most / TILE).clamp(1, TILES);
    [TILE, TILE * high, TILE * TILES.div_ceil(high)]
}

fn fetch(gpu: &Gpu, atlas: &Image3d, sums: &Buffer, count: u32) -> Result<Frame> {
    let mut builder = FrameBuilder::new(gpu, "ceiling_fetch");
    builder
        .pass(&ceiling_fetch::DECLARATION)
        .bind_image("atlas", atlas)
        .bind("sums", sums)
        .constants(&count)
        .items(count);
    builder.build()
}

fn copy(gpu: &Gpu, source: &Buffer, target: &Buffer, count: u32) -> Result<Frame> {
    let mut builder = FrameBuilder::new(gpu, "ceiling_copy");
    builder
        .pass(&ceiling_copy::DECLARATION)
        .bind("source", source)
        .bind("target", target)
        .constants(&count)
        .items(count);
    builder.build()
}

/// Seconds of a run, on the device's clock where it has one.
pub(super) fn seconds(frame: &mut Frame) -> Result<f64> {
    frame.set_profile(Profile::Full);
    let before = Instant::now();
    frame.run()?;
    let wall = before.elapsed().as_secs_f64();
    let device = frame.timings().map(|t| t.gpu_ns as f64 * 1e-9);
    Ok(device.filter(|s| *s > 0.0).unwrap_or(wall))
}

/// Smooth texels with values of the size that fields have.
fn texels(extent: [u32; 3]) -> Vec<[f16; 4]> {
    let [width, height, depth] = extent;
    let texel = |i: u32| {
        let p = [i % width, i / width % height, i / (width * height)];
        let wave = |a: usize| (p[a] as f32 * 0.37).sin() * 0.5 + 0.5;
        [wave(0), wave(1), wave(2), wave(0) * wave(1)].map(f16::from_f32)
    };
    (0..width * height * depth).map(texel).collect()
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::{gpu::testing, twin};

    /// Largest difference between device and twin.
    fn difference(bytes: &[u8], twin: &[[f32; 4]]) -> f32 {
        let device: &[[f32; 4]] = bytemuck::cast_slice(bytes);
        let pairs = device.iter().flatten().zip(twin.iter().flatten());
        pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f32::max)
    }

    #[test]
    fn fetch_agrees_with_its_twin() {
        let Some(gpu) = testing::gpu() else { return };
        let (extent, count) = (super::extent(128), 5000u32);
        let mut texels = texels(extent);
        let atlas = gpu
            .image3d("atlas", Class::Transient, extent, Format::Rgba16F)
            .unwrap();
        gpu.upload_image(&atlas, bytemuck::cast_slice(&texels))
            .unwrap();
        let sums = gpu
            .buffer("sums", Class::Transient, u64::from(count) * 16)
            .unwrap();
        fetch(&gpu, &atlas, &sums, count).unwrap().run().unwrap();
        let device = gpu.download(&sums).unwrap();
        // The positions are quarters of a texel, exact in the 8 bits of a hardware filter, and 16 values of size 1 are
        // summed in floats; filters that work in half floats err by 16 half steps of 2^-12.
        let tolerance = 16.0 / 4096.0;
        let twin = twin::ceiling_fetch(&texels, extent, count);
        assert!(difference(&device, &twin) <= tolerance);
        texels
            .iter_mut()
            .for_each(|t| t[2] = f16::from_f32(t[2].to_f32() + 0.01));
        let perturbed = twin::ceiling_fetch(&texels, extent, count);
        assert!(difference(&device, &perturbed) > tolerance);
    }

    #[test]
    fn copy_agrees_with_its_twin() {
        let Some(gpu) = testing::gpu() else { return };
        let count = 1000u32;
        let mut source: Vec<[f32; 4]> = (0..count).map(|i| [i as f32, 1.5, -2.0, 0.25]).collect();
        let from = gpu
            .buffer_with("from", Class::Transient, bytemuck::cast_slice(&source))
            .unwrap();
        let to = gpu.buffer("to", Class::Transient, from.bytes()).unwrap();
        copy(&gpu, &from, &to, count).unwrap().run().unwrap();
        let device = gpu.download(&to).unwrap();
        assert_eq!(
            difference(&device, &twin::ceiling_copy(&source, count)),
            0.0
        );
        source[999][3] += 1.0;
        assert!(difference(&device, &twin::ceiling_copy(&source, count)) > 0.0);
    }

    #[test]
    fn ceiling_is_measured_and_leaves_no_memory() {
        let Some(gpu) = testing::gpu() else { return };
        let ceiling = gpu.measure_ceiling().unwrap();
        println!("{}: {ceiling:?}", gpu.report().name);
        assert!(ceiling.fetch3d_per_s > 1e6 && ceiling.fetch3d_per_s.is_finite());
        assert!(ceiling.copy_bytes_per_s > 1e7 && ceiling.copy_bytes_per_s.is_finite());
        assert_eq!(gpu.memory().total, 0);
    }
}
