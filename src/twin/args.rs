//! What a twin is run with: the same bindings, constants and extent as its shader.

use bytemuck::Pod;
use half::f16;

/// A 3D image of half-float texels, x fastest.
#[derive(Clone, Debug, Default)]
pub struct Image {
    /// Texels along x, y, z.
    pub extent: [u32; 3],
    /// `extent` texels.
    pub texels: Vec<[f16; 4]>,
}

impl Image {
    /// Trilinear lookup at normalised texture coordinates, clamped to the edge, as a linear sampler does it.
    pub fn sample(&self, at: [f32; 3]) -> [f32; 4] {
        let mut low = [0usize; 3];
        let mut high = [0usize; 3];
        let mut part = [0f32; 3];
        for k in 0..3 {
            let size = self.extent[k];
            let x = at[k] * size as f32 - 0.5;
            let floor = x.floor();
            part[k] = x - floor;
            let last = size as i32 - 1;
            low[k] = (floor as i32).clamp(0, last) as usize;
            high[k] = (floor as i32 + 1).clamp(0, last) as usize;
        }
        let [w, h, _] = self.extent.map(|e| e as usize);
        let texel = |x: usize, y: usize, z: usize| self.texels[(z * h + y) * w + x].map(f32::from);
        let lerp =
            |a: [f32; 4], b: [f32; 4], t: f32| std::array::from_fn(|k| a[k] + (b[k] - a[k]) * t);
        let row = |y, z| lerp(texel(low[0], y, z), texel(high[0], y, z), part[0]);
        let plane = |z| lerp(row(low[1], z), row(high[1], z), part[1]);
        lerp(plane(low[2]), plane(high[2]), part[2])
    }
}

/// One binding of a running twin.
#[derive(Debug)]
pub enum Slot<'a> {
    /// A buffer that the pass reads.
    Read(&'a [u32]),
    /// A buffer that the pass writes.
    Write(&'a mut [u32]),
    /// An image.
    Image(&'a Image),
    /// A written buffer that the twin has already taken.
    Taken,
}

/// Bindings, constants and extent of one run of a twin.
#[derive(Debug)]
pub struct Args<'a> {
    slots: Vec<Slot<'a>>,
    constants: &'a [u8],
    variant: u32,
}

impl<'a> Args<'a> {
    /// Arguments with one slot a binding.
    pub fn new(slots: Vec<Slot<'a>>, constants: &'a [u8]) -> Self {
        Self {
            slots,
            constants,
            variant: 0,
        }
    }

    /// The same with specialization constant 0.
    pub fn with_variant(self, variant: u32) -> Self {
        Self { variant, ..self }
    }

    /// Specialization constant 0.
    pub fn variant(&self) -> u32 {
        self.variant
    }

    /// The push constants.
    pub fn constants<T: Pod>(&self) -> T {
        bytemuck::pod_read_unaligned(self.constants)
    }

    /// Binding `i` as a slice to read; trailing words that make no whole element are left out.
    pub fn read<T: Pod>(&self, i: usize) -> &'a [T] {
        match self.slots[i] {
            Slot::Read(words) => cast(words),
            _ => panic!("binding {i} of a twin is not a buffer to read"),
        }
    }

    /// Binding `i` as a slice to write; can be taken once.
    pub fn write<T: Pod>(&mut self, i: usize) -> &'a mut [T] {
        match std::mem::replace(&mut self.slots[i], Slot::Taken) {
            Slot::Write(words) => {
                let whole = words.len() / (size_of::<T>() / 4) * (size_of::<T>() / 4);
                bytemuck::cast_slice_mut(&mut words[..whole])
            }
            _ => panic!("binding {i} of a twin is not a buffer to write"),
        }
    }

    /// Binding `i` as an image.
    pub fn image(&self, i: usize) -> &'a Image {
        match self.slots[i] {
            Slot::Image(image) => image,
            _ => panic!("binding {i} of a twin is not an image"),
        }
    }
}

/// `words` as whole elements.
pub(crate) fn cast<T: Pod>(words: &[u32]) -> &[T] {
    let per = size_of::<T>() / 4;
    bytemuck::cast_slice(&words[..words.len() / per * per])
}
