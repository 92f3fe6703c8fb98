//! Recording into a command buffer of the host's.

use super::{Frame, Result, Slot, Span, Walk};
use crate::gpu::{Buffer, Handover, HostCommands, Recorder};

impl Frame {
    /// Records runs of steps into a command buffer of the host's, which submits it. They come after all commands before, on the
    /// same queue. Without timestamps.
    ///
    /// # Errors
    /// [`Error::Argument`](crate::Error::Argument) for steps that do not exist.
    pub fn record_spans(
        &mut self,
        commands: &HostCommands,
        slot: Slot,
        spans: &[Span],
    ) -> Result<()> {
        self.count(spans)?;
        let recorder = Recorder {
            shared: &self.gpu.shared,
            raw: commands.0,
        };
        let mut walk = Walk::new(&recorder, &self.program, &mut self.hazards, slot);
        walk.fixed = &self.fixed;
        walk.frame(&self.label, spans);
        Ok(())
    }

    /// Records all steps, and hands over a buffer that they wrote.
    ///
    /// # Errors
    /// As [`Frame::record_spans`].
    pub fn record_and_hand_over(
        &mut self,
        commands: &HostCommands,
        slot: Slot,
        buffer: &Buffer,
        to: &Handover,
    ) -> Result<()> {
        let all = self.all.clone();
        self.record_spans(commands, slot, &all)?;
        let recorder = Recorder {
            shared: &self.gpu.shared,
            raw: commands.0,
        };
        recorder.hand_over(buffer, to);
        Ok(())
    }
}
