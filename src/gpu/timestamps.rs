//! Timestamps and the device's clock.

use std::{
    sync::{
        Arc,
        atomic::{AtomicU8, Ordering},
    },
    time::Instant,
};

use ash::vk;

use super::{
    fault::Subject,
    shared::{Grave, Shared},
};
use crate::Result;

/// How a frame is timed. Timestamps cost time themselves: on lavapipe 25 µs each, as much as a short pass.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Profile {
    /// Without timestamps.
    #[default]
    Off,
    /// The whole of every frame, and the passes in turn, so that the average frame has at most seven timestamps. A pass is
    /// timed in all its steps of a frame, or not in this frame.
    Sampled,
    /// Every step of every frame.
    Full,
}

/// The profile that all who share a device see.
pub(crate) struct SharedProfile(AtomicU8);

impl SharedProfile {
    pub(crate) fn new(profile: Profile) -> Self {
        Self(AtomicU8::new(profile as u8))
    }

    pub(crate) fn get(&self) -> Profile {
        let all = [Profile::Off, Profile::Sampled, Profile::Full];
        let row = self.0.load(Ordering::Relaxed);
        all.into_iter()
            .find(|p| *p as u8 == row)
            .unwrap_or_default()
    }

    pub(crate) fn set(&self, profile: Profile) {
        self.0.store(profile as u8, Ordering::Relaxed);
    }
}

/// A query pool of timestamps.
pub(crate) struct Timestamps {
    shared: Arc<Shared>,
    pub(crate) raw: vk::QueryPool,
    pub(crate) capacity: u32,
}

impl Timestamps {
    pub(crate) fn new(shared: &Arc<Shared>, subject: &str, capacity: u32) -> Result<Self> {
        let info = vk::QueryPoolCreateInfo::default()
            .query_type(vk::QueryType::TIMESTAMP)
            .query_count(capacity);
        // SAFETY: the device is alive; the capacity is not 0.
        let raw = unsafe { shared.device.create_query_pool(&info, None) }
            .subject("vkCreateQueryPool", subject)?;
        shared.name(raw, subject);
        let shared = shared.clone();
        Ok(Self {
            shared,
            raw,
            capacity,
        })
    }

    /// Fills `ticks` with the first timestamps; false where they are not there.
    pub(crate) fn read(&self, ticks: &mut [u64]) -> bool {
        let flags = vk::QueryResultFlags::TYPE_64;
        // SAFETY: the pool is alive and has at least as many queries as `ticks` has rows.
        let read = unsafe {
            self.shared
                .device
                .get_query_pool_results(self.raw, 0, ticks, flags)
        };
        let queue = &self.shared.queue;
        queue
            .note(read, "vkGetQueryPoolResults", "timestamps")
            .is_ok()
    }
}

impl Drop for Timestamps {
    fn drop(&mut self) {
        let raw = self.raw;
        // SAFETY: the graveyard calls this when all submissions are done.
        let destroy = move |d: &ash::Device| unsafe { d.destroy_query_pool(raw, None) };
        self.shared.bury(Grave::Other(Box::new(destroy)));
    }
}

impl Shared {
    /// Nanoseconds of a timestamp on the device's clock.
    pub(crate) fn nanoseconds(&self, ticks: u64) -> u64 {
        let bits = self.physical.family_properties.timestamp_valid_bits;
        let mask = u64::MAX.checked_shr(64 - bits.min(64)).unwrap_or(0);
        let period = f64::from(self.physical.properties.limits.timestamp_period);
        let ticks = ticks & mask;
        // A double holds 53 bits: at a period of 1 the ticks themselves are exact.
        if period == 1.0 {
            ticks
        } else {
            (ticks as f64 * period) as u64
        }
    }

    /// Device and CPU clock at the same moment; `None` where the device's clock cannot be read.
    pub(crate) fn clock(&self) -> Option<(u64, Instant)> {
        let calibrated = self.calibrated.as_ref()?;
        let info =
            [vk::CalibratedTimestampInfoEXT::default().time_domain(vk::TimeDomainEXT::DEVICE)];
        let before = Instant::now();
        // SAFETY: the extension is on; every device that has it has the device's own time domain.
        let (ticks, _) = unsafe { calibrated.get_calibrated_timestamps(&info) }.ok()?;
        let middle = before + before.elapsed() / 2;
        Some((self.nanoseconds(*ticks.first()?), middle))
    }
}
