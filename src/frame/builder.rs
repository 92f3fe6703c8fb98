//! From declared passes to a checked frame.

use std::{borrow::Cow, collections::HashMap, ops::Range};

use ash::vk::{self, Handle};

use super::{
    Frame, build,
    hazard::{Use, Uses},
    program::{Copy, Extent, Fill},
};
use crate::{
    Error, Result,
    gpu::{Access, Buffer, Declaration, Gpu, Image3d, Ring},
};

/// Something that steps read and write.
#[derive(Clone)]
pub(super) enum Resource {
    Buffer(Buffer),
    Ring(Ring),
    Image(Image3d),
}

impl Resource {
    pub(super) fn key(&self) -> u64 {
        match self {
            Self::Buffer(buffer) => buffer.raw().as_raw(),
            Self::Ring(ring) => ring.0[0].raw().as_raw(),
            Self::Image(image) => image.raw().as_raw(),
        }
    }

    pub(super) fn name(&self) -> &str {
        match self {
            Self::Buffer(buffer) => buffer.name(),
            Self::Ring(ring) => ring.name(),
            Self::Image(image) => image.name(),
        }
    }

    pub(super) fn bytes(&self) -> u64 {
        match self {
            Self::Buffer(buffer) => buffer.bytes(),
            Self::Ring(ring) => ring.bytes(),
            Self::Image(image) => image.bytes(),
        }
    }

    /// The CPU may look at it after the frame.
    pub(super) fn is_mapped(&self) -> bool {
        match self {
            Self::Buffer(buffer) => buffer.is_mapped(),
            Self::Ring(_) => true,
            Self::Image(_) => false,
        }
    }

    /// The buffer that a slot uses.
    pub(super) fn buffer(&self, slot: usize) -> Option<&Buffer> {
        match self {
            Self::Buffer(buffer) => Some(buffer),
            Self::Ring(ring) => Some(&ring.0[slot]),
            Self::Image(_) => None,
        }
    }

    fn is_of(&self, gpu: &Gpu) -> bool {
        match self {
            Self::Buffer(buffer) => buffer.is_of(&gpu.shared),
            Self::Ring(ring) => ring.0[0].is_of(&gpu.shared),
            Self::Image(image) => image.is_of(&gpu.shared),
        }
    }
}

impl From<&Buffer> for Resource {
    fn from(buffer: &Buffer) -> Self {
        Self::Buffer(buffer.clone())
    }
}

impl From<&Ring> for Resource {
    fn from(ring: &Ring) -> Self {
        Self::Ring(ring.clone())
    }
}

impl From<&Image3d> for Resource {
    fn from(image: &Image3d) -> Self {
        Self::Image(image.clone())
    }
}

/// One end of a copy: a [`Buffer`] or a [`Ring`], whose slot's buffer it then is.
pub struct End(Resource);

impl From<&Buffer> for End {
    fn from(buffer: &Buffer) -> Self {
        Self(buffer.into())
    }
}

impl From<&Ring> for End {
    fn from(ring: &Ring) -> Self {
        Self(ring.into())
    }
}

/// A step as it was asked for.
pub(super) struct Step {
    pub(super) name: Cow<'static, str>,
    pub(super) label: String,
    pub(super) work: Work,
    /// Resources, each once.
    pub(super) uses: Vec<Use>,
}

pub(super) enum Work {
    Pass(Pass),
    Fill(Fill<usize>),
    Copy(Copy<usize>),
}

pub(super) struct Pass {
    pub(super) declaration: Declaration,
    /// Resource by binding.
    pub(super) bound: Vec<Option<usize>>,
    pub(super) variant: u32,
    pub(super) constants: Vec<u8>,
    pub(super) index_at: Option<usize>,
    pub(super) extent: Option<Extent<usize>>,
}

/// Collects the steps of a frame; mistakes are reported by [`FrameBuilder::build`].
pub struct FrameBuilder {
    pub(super) gpu: Gpu,
    pub(super) name: String,
    pub(super) steps: Vec<Step>,
    pub(super) resources: Vec<Resource>,
    /// Of which the steps are fixed that can be.
    pub(super) sections: Vec<Range<usize>>,
    keys: HashMap<u64, usize>,
    pub(super) error: Option<Error>,
}

impl FrameBuilder {
    /// An empty frame; `name` is the label of the whole.
    pub fn new(gpu: &Gpu, name: &str) -> Self {
        Self {
            gpu: gpu.clone(),
            name: name.to_owned(),
            steps: Vec::new(),
            resources: Vec::new(),
            sections: Vec::new(),
            keys: HashMap::new(),
            error: None,
        }
    }

    /// Number of steps so far: the row of the next one.
    pub fn steps(&self) -> usize {
        self.steps.len()
    }

    /// Adds a pass.
    pub fn pass(&mut self, declaration: &Declaration) -> PassBuilder<'_> {
        let pass = Pass {
            declaration: *declaration,
            bound: vec![None; declaration.bindings.len()],
            variant: 0,
            constants: Vec::new(),
            index_at: None,
            extent: None,
        };
        self.push(declaration.name, Work::Pass(pass), Vec::new());
        PassBuilder { frame: self }
    }

    /// Gives the step added last a label of its own.
    pub fn label(&mut self, label: &str) {
        if let Some(step) = self.steps.last_mut() {
            label.clone_into(&mut step.label);
        }
    }

    /// Sets every 32-bit word of a buffer or of the slot's buffer of a ring.
    pub fn fill(&mut self, to: impl Into<End>, value: u32) {
        let to = to.into();
        let bytes = to.0.bytes() / 4 * 4;
        self.fill_range(to, 0, bytes, value);
    }

    /// Sets the 32-bit words of a range of a buffer; offset and length in bytes, multiples of 4.
    pub fn fill_range(&mut self, to: impl Into<End>, offset: u64, bytes: u64, value: u32) {
        let to = self.resource(to.into().0, "fill");
        let end = offset.saturating_add(bytes);
        let in_words = (offset | bytes).is_multiple_of(4);
        if end > self.resources[to].bytes() || !in_words {
            let reason = format!("{bytes} bytes from {offset} on are no words of it");
            let name = self.resources[to].name().to_owned();
            self.fail(Error::argument(name, reason));
        }
        let fill = Fill {
            to,
            offset,
            bytes,
            value,
        };
        self.push(
            "fill",
            Work::Fill(fill),
            vec![(to as u32, Uses::TRANSFER_WRITE)],
        );
        let label = format!("fill {}", self.resources[to].name());
        self.label(&label);
    }

    /// Copies `bytes` from the beginning of one buffer to the beginning of another.
    pub fn copy(&mut self, from: impl Into<End>, to: impl Into<End>, bytes: u64) {
        self.copy_slice(from, to, bytes, [0, 0]);
    }

    /// Copies `bytes` between two buffers, each from as many times its stride on as [`Span::index`](super::Span::index) says;
    /// where that passes an end, submitting fails.
    pub fn copy_slice(
        &mut self,
        from: impl Into<End>,
        to: impl Into<End>,
        bytes: u64,
        strides: [u64; 2],
    ) {
        let from = self.resource(from.into().0, "copy");
        let to = self.resource(to.into().0, "copy");
        let (a, b) = (&self.resources[from], &self.resources[to]);
        let label = format!("copy {} to {}", a.name(), b.name());
        let most = a.bytes().min(b.bytes());
        if from == to || bytes == 0 || bytes > most || strides.iter().any(|s| s % 4 != 0) {
            let reason = format!("{bytes} bytes, where two buffers and 1 to {most} are needed");
            self.fail(Error::argument(&label, reason));
        }
        let rows = [from as u32, to as u32];
        let uses = vec![
            (rows[0], Uses::TRANSFER_READ),
            (rows[1], Uses::TRANSFER_WRITE),
        ];
        let copy = Copy {
            from,
            to,
            bytes,
            strides,
        };
        self.push("copy", Work::Copy(copy), uses);
        self.label(&label);
    }

    /// Has those steps of a section recorded once and for all that are the same in every frame, whatever its slot and the span's
    /// index. Spans that go through a section as a whole execute them, unless a submission is timed; what a fixed step does cannot
    /// be changed any more.
    pub fn fix(&mut self, section: Range<usize>) {
        self.sections.push(section);
    }

    /// Checks everything and makes pipelines, descriptor sets and command buffers.
    ///
    /// # Errors
    /// [`Error::Pass`] where a pass lacks a binding, its constants or extent, or disagrees with its shader;
    /// [`Error::Argument`] for a copy that does not fit or a section of steps that do not exist; [`Error::Vulkan`] where the driver fails.
    pub fn build(self) -> Result<Frame> {
        build::build(self)
    }

    fn push(&mut self, name: &'static str, work: Work, uses: Vec<Use>) {
        let (name, label) = (Cow::Borrowed(name), name.to_owned());
        self.steps.push(Step {
            name,
            label,
            work,
            uses,
        });
    }

    fn resource(&mut self, resource: Resource, user: &str) -> usize {
        if !resource.is_of(&self.gpu) {
            let reason = format!("{user} uses it on another device than it was made on");
            self.fail(Error::argument(resource.name(), reason));
        }
        let next = self.resources.len();
        let row = *self.keys.entry(resource.key()).or_insert(next);
        if row == next {
            self.resources.push(resource);
        }
        row
    }

    /// Keeps the first mistake.
    fn fail(&mut self, error: Error) {
        self.error.get_or_insert(error);
    }
}

/// Completes the pass that was just added.
pub struct PassBuilder<'a> {
    frame: &'a mut FrameBuilder,
}

impl PassBuilder<'_> {
    /// Binds a buffer by the binding's name.
    pub fn bind(self, name: &str, buffer: &Buffer) -> Self {
        self.bind_resource(name, buffer.into())
    }

    /// Binds the slot's buffer of a ring by the binding's name.
    pub fn bind_ring(self, name: &str, ring: &Ring) -> Self {
        self.bind_resource(name, ring.into())
    }

    /// Binds an image by the binding's name.
    pub fn bind_image(self, name: &str, image: &Image3d) -> Self {
        self.bind_resource(name, image.into())
    }

    /// Sets the push constants; as many bytes as the pass declares.
    pub fn constants<T: bytemuck::NoUninit>(mut self, constants: &T) -> Self {
        self.work().constants = bytemuck::bytes_of(constants).to_vec();
        self
    }

    /// Sets specialization constant 0 of the shader, 0 otherwise.
    pub fn variant(mut self, variant: u32) -> Self {
        self.work().variant = variant;
        self
    }

    /// Sets the push constants from their bytes.
    pub fn constant_bytes(mut self, bytes: &[u8]) -> Self {
        self.work().constants = bytes.to_vec();
        self
    }

    /// Has the 32-bit word at this byte of the push constants hold [`Span::index`](super::Span::index).
    pub fn index_at(mut self, byte: usize) -> Self {
        self.work().index_at = Some(byte);
        self
    }

    /// Dispatches as many workgroups.
    pub fn groups(mut self, groups: [u32; 3]) -> Self {
        self.work().extent = Some(Extent::Groups(groups));
        self
    }

    /// Dispatches as many workgroups along x as hold `items` invocations.
    pub fn items(mut self, items: u32) -> Self {
        let size = self.work().declaration.local_size[0].max(1);
        self.groups([items.div_ceil(size), 1, 1])
    }

    /// Repeats the workgroups along y, for so many instances.
    pub fn instances(mut self, instances: u32) -> Self {
        if let Some(Extent::Groups(groups)) = &mut self.work().extent {
            groups[1] = groups[1].saturating_mul(instances);
        }
        self
    }

    /// Dispatches as many workgroups as the three 32-bit counts at `offset` bytes in `buffer` say.
    pub fn indirect(mut self, buffer: &Buffer, offset: u64) -> Self {
        let name = self.work().declaration.name;
        let row = self.frame.resource(buffer.into(), name);
        if !offset.is_multiple_of(4) || offset.saturating_add(12) > buffer.bytes() {
            let reason = format!("no three counts at byte {offset} of {}", buffer.name());
            self.fail(reason);
        }
        self.work().extent = Some(Extent::Indirect(row, offset));
        self.use_for(row, Uses::INDIRECT);
        self
    }

    /// Gives this step a label of its own; the default is the pass's name.
    pub fn label(self, label: &str) -> Self {
        self.frame.label(label);
        self
    }

    /// Row of this step in the frame.
    pub fn step(self) -> usize {
        self.frame.steps.len() - 1
    }

    fn bind_resource(mut self, name: &str, resource: Resource) -> Self {
        let declaration = self.work().declaration;
        let Some(row) = declaration.bindings.iter().position(|b| b.name == name) else {
            self.fail(format!("it has no binding {name:?}"));
            return self;
        };
        let access = declaration.bindings[row].access;
        if let Some(reason) = self.misfit(access, &resource) {
            self.fail(format!("binding {name:?}: {reason}"));
            return self;
        }
        let resource = self.frame.resource(resource, declaration.name);
        if self.work().bound[row].replace(resource).is_some() {
            self.fail(format!("binding {name:?} is bound twice"));
        }
        self.use_for(resource, Uses::of(access));
        self
    }

    fn misfit(&self, access: Access, resource: &Resource) -> Option<String> {
        let is_image = matches!(resource, Resource::Image(_));
        let (name, bytes) = (resource.name(), resource.bytes());
        let limits = self.frame.gpu.limits();
        if access.is_image() != is_image {
            let is = if is_image { "an image" } else { "a buffer" };
            return Some(format!("{name} is {is}, {access:?} is declared"));
        }
        let (kind, most) = longest(access, limits)?;
        (bytes > most).then(|| {
            format!("{name} has {bytes} bytes, a {kind} buffer {most} at most on this device")
        })
    }

    fn use_for(&mut self, resource: usize, uses: Uses) {
        let Some(step) = self.frame.steps.last_mut() else {
            return;
        };
        let row = resource as u32;
        match step.uses.iter_mut().find(|u| u.0 == row) {
            Some(known) => known.1 = known.1.with(uses),
            None => step.uses.push((row, uses)),
        }
    }

    fn work(&mut self) -> &mut Pass {
        match self.frame.steps.last_mut().map(|s| &mut s.work) {
            Some(Work::Pass(pass)) => pass,
            _ => unreachable!("a pass builder borrows the frame that ends in its pass"),
        }
    }

    fn fail(&mut self, reason: String) {
        let pass = self.work().declaration.name;
        self.frame.fail(Error::Pass { pass, reason });
    }
}

/// Kind and greatest length in bytes of a buffer that is bound like this, where that is less than of any buffer.
fn longest(access: Access, limits: &vk::PhysicalDeviceLimits) -> Option<(&'static str, u64)> {
    let texels = u64::from(limits.max_texel_buffer_elements);
    match access {
        Access::Uniform => Some(("uniform", u64::from(limits.max_uniform_buffer_range))),
        Access::Texels => Some(("texel", 16 * texels)),
        Access::Words => Some(("texel", 4 * texels)),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texel_buffers_are_as_long_as_their_elements_and_uniform_ones_as_their_range() {
        let limits = vk::PhysicalDeviceLimits {
            max_texel_buffer_elements: 65_536,
            max_uniform_buffer_range: 16_384,
            ..Default::default()
        };
        let longest = |access| longest(access, &limits);
        assert_eq!(longest(Access::Words), Some(("texel", 262_144)));
        assert_eq!(longest(Access::Texels), Some(("texel", 1_048_576)));
        assert_eq!(longest(Access::Uniform), Some(("uniform", 16_384)));
        assert_eq!(longest(Access::Read), None);
    }
}
