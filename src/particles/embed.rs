//! Particles in a host's frame.

use super::{
    Particles,
    machine::{By, Machine},
};
use crate::{
    Error, Result,
    deformer::{Normals, Output, VertexLayout, frame_slot, no_commands},
    gpu::{Buffer, Handover, HostCommands},
    sphere_mesh::Ball,
};

impl Particles {
    /// A buffer of the host's that [`Particles::record`] fills, a vertex a particle: its position, and its velocity where the layout
    /// has normals, which are [`Normals::Float`] then. To whom it is handed over, as by [`Deformer::output`](crate::deformer::Deformer::output).
    ///
    /// # Errors
    /// [`Error::Argument`] on the CPU, for a layout that does not fit into the buffer or has normals in bytes, for a buffer of
    /// another device, and for a queue family that the device has not; Vulkan errors.
    pub fn output(
        &self,
        buffer: &Buffer,
        layout: &VertexLayout,
        handover: &Handover,
    ) -> Result<Output> {
        let Machine::Gpu(m) = &self.machine else {
            return Err(no_commands());
        };
        if let Normals::Byte(_) = layout.normals {
            let reason = "velocities do not fit into bytes";
            return Err(Error::argument("vertex layout", reason));
        }
        let constants = layout.constants(self.count, 1, buffer.bytes())?;
        let [positions, velocities] = &m.rows;
        Output::new(
            &m.gpu,
            [positions, velocities],
            (buffer, handover),
            &constants,
            1,
        )
    }

    /// Records a frame into a command buffer of the host's: what [`Particles::advance`] submits, and the writing of `output` where
    /// there is one. Submits nothing, waits for nothing, allocates nothing.
    ///
    /// The frame comes after all commands before it on the same queue. What was recorded with the same slot before has to be done.
    ///
    /// # Errors
    /// [`Error::Argument`] on the CPU, for a slot that does not exist or an output of other particles, and as
    /// [`Particles::advance`]. The shape has not moved then.
    pub fn record(
        &mut self,
        commands: &HostCommands,
        slot: usize,
        balls: &[Ball],
        seconds: f32,
        output: Option<&mut Output>,
    ) -> Result<()> {
        let slot = frame_slot(slot)?;
        let Machine::Gpu(m) = &self.machine else {
            return Err(no_commands());
        };
        if output.as_ref().is_some_and(|o| !o.is_from(&m.rows[0])) {
            return Err(Error::argument(
                "output",
                "it was made with other particles",
            ));
        }
        let constants = self.go(balls, seconds)?;
        let Machine::Gpu(m) = &mut self.machine else {
            return Err(no_commands());
        };
        let done = m
            .set(By::Host, slot, self.moving.primitives(), &constants)
            .and_then(|()| m.frame.record_spans(commands, slot, &By::Host.spans()))
            .and_then(|()| output.map_or(Ok(()), |output| output.record(commands, slot)));
        done.inspect_err(|_| self.moving.turn_back())
    }
}
