//! In a host's frame: recording into its command buffer, writing into its vertex buffer.

use ash::vk;

use super::{Deformer, Poses, Resource, machine::Machine};
use crate::{
    Error, Result,
    frame::{Frame, FrameBuilder, Slot},
    gpu::{Buffer, FRAMES_IN_FLIGHT, Gpu, Handover, HostCommands},
    pass,
};

/// How normals lie in a host's vertex.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Normals {
    /// Not at all.
    #[default]
    None,
    /// Three 32-bit floats, at this offset from the vertex's beginning.
    Float(u64),
    /// Three signed normalised bytes and a byte of 0, at this offset from the vertex's beginning.
    Byte(u64),
}

/// How vertices lie in a host's buffer, in bytes, each a multiple of 4. A vertex begins with its position, three 32-bit floats;
/// what is not named here stays as it is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct VertexLayout {
    /// Where the first vertex begins.
    pub offset: u64,
    /// From vertex to vertex.
    pub stride: u64,
    /// From the first vertex of an instance to that of the next; of no meaning for one instance.
    pub instance_stride: u64,
    /// Normals.
    pub normals: Normals,
}

/// A buffer of the host's into which recorded frames write their skin, or particles. Dropped before its deformer or after, but only
/// when the device is done with the commands that use it.
pub struct Output {
    frame: Frame,
    buffer: Buffer,
    handover: Handover,
    /// Positions that it is filled from.
    source: vk::Buffer,
}

impl Output {
    /// Filled from positions and normals, each four numbers a row, of so many instances.
    pub(crate) fn new(
        gpu: &Gpu,
        [positions, normals]: [&Buffer; 2],
        (buffer, handover): (&Buffer, &Handover),
        constants: &pass::output::Constants,
        instances: u32,
    ) -> Result<Self> {
        gpu.check_handover(handover)?;
        let mut builder = FrameBuilder::new(gpu, "output");
        builder
            .pass(&pass::output::DECLARATION)
            .bind("skin_positions", positions)
            .bind("skin_normals", normals)
            .bind("host_vertices", buffer)
            .constants(constants)
            .items(constants.rows)
            .instances(instances);
        Ok(Self {
            frame: builder.build()?,
            buffer: buffer.clone(),
            handover: *handover,
            source: positions.raw(),
        })
    }

    /// It is filled from these positions.
    pub(crate) fn is_from(&self, positions: &Buffer) -> bool {
        self.source == positions.raw()
    }

    /// Records the filling, and hands the buffer over.
    pub(crate) fn record(&mut self, commands: &HostCommands, slot: Slot) -> Result<()> {
        let (buffer, handover) = (&self.buffer, &self.handover);
        self.frame
            .record_and_hand_over(commands, slot, buffer, handover)
    }
}

/// The slot of this number.
pub(crate) fn frame_slot(slot: usize) -> Result<Slot> {
    Slot::new(slot).ok_or_else(|| {
        let reason = format!("{slot} of {FRAMES_IN_FLIGHT}");
        Error::argument("frame slot", reason)
    })
}

impl VertexLayout {
    /// The pass's constants for `rows` vertices of each of `instances` in `bytes`.
    pub(crate) fn constants(
        &self,
        rows: u32,
        instances: u32,
        bytes: u64,
    ) -> Result<pass::output::Constants> {
        let refuse = |reason: String| Err(Error::argument("vertex layout", reason));
        let (normals, normal_offset, room) = match self.normals {
            Normals::None => (pass::output::NO_NORMALS, 0, 0),
            Normals::Float(at) => (pass::output::FLOAT_NORMALS, at, 12),
            Normals::Byte(at) => (pass::output::BYTE_NORMALS, at, 4),
        };
        let instance = if instances > 1 {
            self.instance_stride
        } else {
            0
        };
        let all = [self.offset, self.stride, instance, normal_offset];
        if let Some(odd) = all.iter().find(|x| !x.is_multiple_of(4)) {
            return refuse(format!("{odd} is no multiple of 4"));
        }
        let end = normal_offset.saturating_add(room);
        if room > 0 && normal_offset < 12 {
            return refuse(format!(
                "normals at {normal_offset} lie in the position's 12 bytes"
            ));
        }
        if self.stride < end.max(12) {
            return refuse(format!(
                "a vertex of {} bytes ends at {}",
                self.stride,
                end.max(12)
            ));
        }
        let before =
            |count: u32, stride: u64| u64::from(count).saturating_sub(1).saturating_mul(stride);
        let one = before(rows, self.stride).saturating_add(end.max(12));
        if instances > 1 && instance < one {
            return refuse(format!(
                "an instance of {instance} bytes ends at {one}, in the next one"
            ));
        }
        let needed = before(instances, instance)
            .saturating_add(self.offset)
            .saturating_add(one);
        if needed > bytes {
            let of = match instances {
                1 => String::new(),
                n => format!(" of each of {n} instances"),
            };
            let reason = format!("{rows} vertices{of} end at byte {needed} of {bytes}");
            return refuse(reason);
        }
        // A buffer that is bound to a shader has less than 2^32 bytes, and so has all within.
        Ok(pass::output::Constants {
            rows,
            offset: (self.offset / 4) as u32,
            stride: (self.stride / 4) as u32,
            normal_offset: (normal_offset / 4) as u32,
            instance: (instance / 4) as u32,
            normals,
        })
    }
}

impl Deformer {
    /// A buffer of the host's ([`Gpu::host_buffer`](crate::gpu::Gpu::host_buffer)) that [`Deformer::record`] fills, a vertex a row of the file, instance after
    /// instance, and to whom it is handed over.
    ///
    /// # Errors
    /// [`Error::Argument`] on the CPU, for a layout that does not fit into the buffer, for one of another device, and for a queue
    /// family that the device has not; Vulkan errors.
    pub fn output(
        &self,
        buffer: &Buffer,
        layout: &VertexLayout,
        handover: &Handover,
    ) -> Result<Output> {
        let Machine::Gpu(m) = &self.machine else {
            return Err(no_commands());
        };
        let constants =
            layout.constants(self.statics.sizes.rows, self.instances(), buffer.bytes())?;
        let skin = [Resource::SkinPositions, Resource::SkinNormals];
        Output::new(
            &m.gpu,
            skin.map(|r| m.resources.buffer(r)),
            (buffer, handover),
            &constants,
            self.instances(),
        )
    }

    /// Records a frame into a command buffer of the host's: everything that [`Deformer::advance`] submits, and the writing of
    /// `output` where there is one. Submits nothing, waits for nothing, allocates nothing.
    ///
    /// The frame comes after all commands before it on the same queue; what was bound before it is not bound after it. Poses are
    /// deformed in the order of their recording, which has to be that of their submission.
    ///
    /// # Errors
    /// [`Error::Argument`] on the CPU, for a slot that does not exist, an output of another deformer, or where there are not as
    /// many poses as instances; [`Error::Pose`] as [`Deformer::advance`].
    pub fn record<'a>(
        &mut self,
        commands: &HostCommands,
        slot: usize,
        poses: impl Into<Poses<'a>>,
        output: Option<&mut Output>,
    ) -> Result<()> {
        let slot = frame_slot(slot)?;
        self.check_output(output.as_deref())?;
        self.set_poses(poses.into())?;
        let Machine::Gpu(m) = &mut self.machine else {
            return Err(no_commands());
        };
        m.resources.pose(slot, &self.upload)?;
        m.order(&self.upload);
        m.frame.record_spans(commands, slot, &m.spans)?;
        if let Some(output) = output {
            output.record(commands, slot)?;
        }
        self.follow();
        Ok(())
    }

    /// Before anything changes: an error leaves the deformer as it was.
    fn check_output(&self, output: Option<&Output>) -> Result<()> {
        let Machine::Gpu(m) = &self.machine else {
            return Err(no_commands());
        };
        match output {
            Some(output) if !output.is_from(m.resources.buffer(Resource::SkinPositions)) => {
                let reason = "it was made with another deformer";
                Err(Error::argument("output", reason))
            }
            _ => Ok(()),
        }
    }
}

pub(crate) fn no_commands() -> Error {
    Error::argument("device", "the cpu device records no commands")
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    #[test]
    fn layouts_that_do_not_fit_are_refused() {
        let layout = |offset, stride, normals| VertexLayout {
            offset,
            stride,
            instance_stride: 0,
            normals,
        };
        let good = layout(8, 32, Normals::Float(16));
        let c = good.constants(3, 1, 8 + 2 * 32 + 28).unwrap();
        assert_eq!((c.offset, c.stride, c.normal_offset), (2, 8, 4));
        for (layout, bytes, reason) in [
            (good, 8 + 2 * 32 + 27, "end at byte"),
            (layout(2, 32, Normals::None), 1000, "multiple of 4"),
            (layout(0, 30, Normals::None), 1000, "multiple of 4"),
            (layout(0, 8, Normals::None), 1000, "ends at 12"),
            (layout(0, 32, Normals::Byte(8)), 1000, "position"),
            (layout(0, 32, Normals::Float(24)), 1000, "ends at 36"),
            (layout(!3, 32, Normals::None), 1000, "end at byte"),
            (layout(0, !3, Normals::None), 1000, "end at byte"),
        ] {
            let error = layout.constants(3, 1, bytes).unwrap_err().to_string();
            assert!(error.contains(reason), "{error}");
        }
        let (several, end) = (
            |instance_stride| VertexLayout {
                instance_stride,
                ..good
            },
            8 + 2 * 32 + 28,
        );
        let c = several(96).constants(3, 4, 3 * 96 + end).unwrap();
        assert_eq!(c.instance, 24);
        for (layout, bytes, reason) in [
            (
                several(96),
                3 * 96 + end - 1,
                "of each of 4 instances end at",
            ),
            (several(94), 1000, "multiple of 4"),
            (several(88), 1000, "in the next one"),
            (several(!3), 1000, "end at byte"),
        ] {
            let error = layout.constants(3, 4, bytes).unwrap_err().to_string();
            assert!(error.contains(reason), "{error}");
        }
    }
}
