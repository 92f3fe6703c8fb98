//! The frames of a bench, in turns that time every pass once, with the ceiling measured between them.

use dermis::{
    Result,
    deformer::{Deformer, Device, Method, Settings},
    frame::{CeilingMeter, LEAST_PLACES, ReplayMeter, StampMeter},
    gpu::{Gpu, Profile},
    report::{Ceiling, MemoryReport},
    rig::Pose,
};

use crate::{
    samples::{Samples, play},
    session::Session,
};

/// Least number of times that every pass is timed.
const ROUNDS: usize = 9;
/// Least number of frames.
const FRAMES: usize = 60;

/// How many frames to play.
pub(crate) struct Length {
    /// Unmeasured, at the beginning.
    pub(crate) warm_up: usize,
    /// Measured, at least; `None` for as many as the statistics need.
    pub(crate) frames: Option<usize>,
}

/// What a bench measured.
pub(crate) struct Measured {
    pub(crate) samples: Samples,
    pub(crate) memory: MemoryReport,
    pub(crate) instances: u32,
    /// One a round.
    pub(crate) ceilings: Vec<Ceiling>,
    /// Wall-clock of the same frames without timestamps, where they were to be compared.
    pub(crate) plain_ns: Vec<u64>,
}

/// What is measured on a device of its own, between the frames.
struct Meters {
    gpu: Gpu,
    ceiling: CeilingMeter,
    stamp: StampMeter,
    /// None where nothing is projected.
    replay: Option<ReplayMeter>,
}

impl Meters {
    fn new(gpu: &Gpu) -> Result<Self> {
        Ok(Self {
            gpu: gpu.clone(),
            ceiling: CeilingMeter::new(gpu)?,
            stamp: StampMeter::new(gpu)?,
            replay: None,
        })
    }

    /// Takes the samples of the deformer's last frame for its own; a round samples every place `steps` times.
    fn follow(&mut self, deformer: &mut Deformer) -> Result<()> {
        let places = deformer.places()?;
        if places.places.len() >= LEAST_PLACES {
            let (texels, steps) = (&places.texels, deformer.settings().steps);
            let meter = ReplayMeter::new(&self.gpu, places.extent, texels, &places.places, steps)?;
            self.replay = Some(meter);
        }
        Ok(())
    }

    fn measure(&mut self) -> Result<(Ceiling, u64)> {
        let mut ceiling = self.ceiling.measure()?;
        if let Some(replay) = &mut self.replay {
            ceiling.replay3d_per_s = replay.measure()?;
        }
        Ok((ceiling, self.stamp.measure()?))
    }
}

/// A deformer to be measured, and what is measured beside it.
pub(crate) struct Run {
    deformer: Deformer,
    gpu: Option<Gpu>,
    meters: Option<Meters>,
    compare: bool,
}

impl Run {
    /// `compare` plays every frame without timestamps, too.
    pub(crate) fn new(
        session: &Session,
        deformer: Deformer,
        ceiling: Option<&Gpu>,
        compare: bool,
    ) -> Result<Self> {
        let gpu = match &session.device {
            Device::Gpu(gpu) => Some(gpu.clone()),
            Device::Cpu => None,
        };
        Ok(Self {
            deformer,
            gpu,
            meters: ceiling.map(Meters::new).transpose()?,
            compare,
        })
    }

    /// Plays `poses` again and again.
    pub(crate) fn measure(mut self, poses: &[Pose], length: Length) -> Result<Measured> {
        let mut samples = Samples::default();
        let mut course = Course::new(poses, self.deformer.settings());
        for i in 0..length.warm_up.max(1) {
            samples.play(&mut self.deformer, course.poses(i))?;
        }
        if let Some(meters) = &mut self.meters {
            meters.follow(&mut self.deformer)?;
        }
        let turns = samples.turns.max(1);
        let frames = length.frames.unwrap_or(FRAMES.max(ROUNDS * turns));
        let stride = stride(turns, poses.len());
        samples = Samples::default();
        let (mut ceilings, mut plain_ns) = (Vec::new(), Vec::new());
        let mut excess_ns = Vec::new();
        for round in 0..frames.div_ceil(turns) {
            let first = round * stride;
            if let Some(meters) = &mut self.meters {
                let (ceiling, excess) = meters.measure()?;
                ceilings.push(ceiling);
                excess_ns.push(excess);
                // The meters leave the caches cold.
                self.plain(course.poses(first))?;
            }
            for turn in 0..turns {
                // The two take turns in going first, so that neither always finds warm caches.
                let plain_first = (round + turn) % 2 == 1;
                if self.compare && plain_first {
                    plain_ns.push(self.plain(course.poses(first + turn))?);
                }
                samples.play(&mut self.deformer, course.poses(first + turn))?;
                if self.compare && !plain_first {
                    plain_ns.push(self.plain(course.poses(first + turn))?);
                }
            }
        }
        samples.take_off(median_of(excess_ns));
        Ok(Measured {
            samples,
            memory: self.deformer.memory(),
            instances: self.deformer.instances(),
            ceilings,
            plain_ns,
        })
    }

    /// A frame without timestamps, which takes no turn.
    fn plain(&mut self, poses: &[Pose]) -> Result<u64> {
        let profile = |profile| {
            if let Some(gpu) = &self.gpu {
                gpu.set_profile(profile);
            }
        };
        profile(Profile::Off);
        let played = play(&mut self.deformer, poses);
        profile(Profile::Sampled);
        played
    }
}

/// The poses in the order in which they are played, by every instance from a place of its own.
struct Course<'a> {
    all: &'a [Pose],
    instances: usize,
    /// Those of a frame, one an instance.
    frame: Vec<Pose>,
    /// Frames so far, for a method whose frames follow from each other: these are played one after the other.
    played: Option<usize>,
}

impl<'a> Course<'a> {
    fn new(all: &'a [Pose], settings: &Settings) -> Self {
        Self {
            all,
            instances: settings.instances as usize,
            frame: Vec::new(),
            played: (settings.method == Method::Tracking).then_some(0),
        }
    }

    /// The poses of this row, or of the next one.
    fn poses(&mut self, row: usize) -> &[Pose] {
        let row = match &mut self.played {
            Some(played) => std::mem::replace(played, *played + 1),
            None => row,
        };
        let (count, instances) = (self.all.len(), self.instances);
        let place = |instance: usize| row + instance * count / instances;
        self.frame.clear();
        let frame = (0..instances).map(|i| self.all[place(i) % count].clone());
        self.frame.extend(frame);
        &self.frame
    }
}

fn median_of(mut values: Vec<u64>) -> u64 {
    values.sort_unstable();
    values.get(values.len() / 2).copied().unwrap_or(0)
}

/// Poses from one round to the next: at least a round's frames, and no divisor in common with the number of poses, so that
/// no pass meets the same few poses again and again.
fn stride(turns: usize, poses: usize) -> usize {
    let common = |mut a: usize, mut b: usize| {
        while b > 0 {
            (a, b) = (b, a % b);
        }
        a
    };
    let strides = turns..turns + poses.max(1);
    strides
        .into_iter()
        .find(|stride| common(*stride, poses) == 1)
        .unwrap_or(turns)
}

#[cfg(test)]
mod tests {
    use super::*;
    use dermis::rig::Pose;
    use glam::Mat4;
    use std::collections::BTreeSet;

    #[test]
    fn instances_play_from_places_evenly_apart() {
        let pose = |x: i32| Pose {
            matrices: vec![Mat4::from_scale(glam::Vec3::splat(x as f32))],
        };
        let all: Vec<Pose> = (0..8).map(pose).collect();
        let settings = |method, instances| Settings {
            method,
            instances,
            ..Settings::default()
        };
        let rows = |course: &mut Course<'_>, row| -> Vec<f32> {
            let poses = course.poses(row).iter();
            poses.map(|p| p.matrices[0].x_axis.x).collect()
        };
        let mut course = Course::new(&all, &settings(Method::Implicit, 4));
        assert_eq!(rows(&mut course, 0), [0.0, 2.0, 4.0, 6.0]);
        assert_eq!(rows(&mut course, 7), [7.0, 1.0, 3.0, 5.0]);
        // Tracked frames follow from each other.
        let mut course = Course::new(&all, &settings(Method::Tracking, 1));
        let played: Vec<_> = [5, 5, 5].map(|row| rows(&mut course, row)).concat();
        assert_eq!(played, [0.0, 1.0, 2.0]);
    }

    #[test]
    fn every_turn_meets_every_pose_in_time() {
        for (turns, poses) in [(16, 60), (1, 60), (10, 1), (7, 49), (12, 25)] {
            let stride = stride(turns, poses);
            assert!(stride >= turns);
            for turn in 0..turns {
                let met: BTreeSet<_> = (0..poses).map(|r| (r * stride + turn) % poses).collect();
                assert_eq!(met.len(), poses, "{turns} turns, {poses} poses");
            }
        }
    }
}
