//! What a pass says about itself; checked against its SPIR-V when the pipeline is made.

/// A compute pass as its shader and its user see it.
#[derive(Clone, Copy, Debug)]
pub struct Declaration {
    /// Unique name: file, label and timing key.
    pub name: &'static str,
    /// The shader.
    pub spirv: &'static [u8],
    /// Bindings of descriptor set 0; the row is the binding number.
    pub bindings: &'static [Binding],
    /// Bytes of push constants.
    pub constants: u32,
    /// Size of a workgroup.
    pub local_size: [u32; 3],
}

/// One resource that a pass uses.
#[derive(Clone, Copy, Debug)]
pub struct Binding {
    /// Name that the frame binds by.
    pub name: &'static str,
    /// What the pass does with it.
    pub access: Access,
}

impl Binding {
    /// A binding.
    pub const fn new(name: &'static str, access: Access) -> Self {
        Self { name, access }
    }

    /// A `readonly` storage buffer.
    pub const fn read(name: &'static str) -> Self {
        Self::new(name, Access::Read)
    }

    /// A buffer read as `vec4` texels.
    pub const fn texels(name: &'static str) -> Self {
        Self::new(name, Access::Texels)
    }

    /// A buffer read as words.
    pub const fn words(name: &'static str) -> Self {
        Self::new(name, Access::Words)
    }

    /// A `writeonly` storage buffer.
    pub const fn write(name: &'static str) -> Self {
        Self::new(name, Access::Write)
    }

    /// A storage buffer that is read and written.
    pub const fn read_write(name: &'static str) -> Self {
        Self::new(name, Access::ReadWrite)
    }
}

/// What a pass does with a resource.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Access {
    /// `readonly` storage buffer.
    Read,
    /// `writeonly` storage buffer.
    Write,
    /// Storage buffer without qualifier.
    ReadWrite,
    /// Uniform buffer.
    Uniform,
    /// Buffer read as `vec4` texels through a `samplerBuffer`: software rasterisers fetch texels for all lanes at once, but
    /// load storage buffers lane by lane.
    Texels,
    /// Buffer read as words through a `usamplerBuffer`.
    Words,
    /// 3D image with the linear sampler that clamps to the edge.
    Sampled,
    /// `writeonly` 3D storage image.
    ImageWrite,
}

impl Access {
    /// The shader may read the resource.
    pub fn reads(self) -> bool {
        !matches!(self, Self::Write | Self::ImageWrite)
    }

    /// The shader may write the resource.
    pub fn writes(self) -> bool {
        matches!(self, Self::Write | Self::ReadWrite | Self::ImageWrite)
    }

    /// The resource is an image.
    pub fn is_image(self) -> bool {
        matches!(self, Self::Sampled | Self::ImageWrite)
    }
}
