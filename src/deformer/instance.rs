//! One of the instances of a deformer: its skin and its tracked state.

use glam::Vec3;

use super::{Deformer, Method, Resource, Skin, TrackedState, statics};
use crate::{
    Error, Result,
    layout::state,
    rig::{Pose, Rig},
};

/// Poses for all instances of a deformer, in their order: from one pose, a slice, an array or a vector.
#[derive(Clone, Copy, Debug)]
pub struct Poses<'a>(&'a [Pose]);

impl<'a> From<&'a Pose> for Poses<'a> {
    fn from(pose: &'a Pose) -> Self {
        Self(std::slice::from_ref(pose))
    }
}

impl<'a> From<&'a [Pose]> for Poses<'a> {
    fn from(poses: &'a [Pose]) -> Self {
        Self(poses)
    }
}

impl<'a, const N: usize> From<&'a [Pose; N]> for Poses<'a> {
    fn from(poses: &'a [Pose; N]) -> Self {
        Self(poses)
    }
}

impl<'a> From<&'a Vec<Pose>> for Poses<'a> {
    fn from(poses: &'a Vec<Pose>) -> Self {
        Self(poses)
    }
}

impl<'a> Poses<'a> {
    /// One valid pose for every one of `instances`.
    pub(super) fn checked(self, rig: &Rig, instances: u32) -> Result<&'a [Pose]> {
        if self.0.len() != instances as usize {
            let reason = format!("{} for {instances} instances", self.0.len());
            return Err(Error::argument("poses", reason));
        }
        for pose in self.0 {
            pose.validate(&rig.skeleton)?;
        }
        Ok(self.0)
    }
}

/// An instance of a deformer, from [`Deformer::instance`].
pub struct Instance<'a> {
    pub(super) deformer: &'a mut Deformer,
    pub(super) row: usize,
}

impl Deformer {
    /// Number of instances ([`Settings::instances`](super::Settings::instances)).
    pub fn instances(&self) -> u32 {
        self.settings.instances
    }

    /// The instance of this number, counted from 0.
    ///
    /// # Errors
    /// [`Error::Argument`] with subject `instance` where there is none.
    pub fn instance(&mut self, row: u32) -> Result<Instance<'_>> {
        let count = self.instances();
        if row >= count {
            let reason = format!("{row}, counted from 0, of {count}");
            return Err(Error::argument("instance", reason));
        }
        Ok(Instance {
            deformer: self,
            row: row as usize,
        })
    }
}

impl Instance<'_> {
    /// Its last deformed skin; waits for it.
    ///
    /// # Errors
    /// Vulkan errors.
    pub fn read(&mut self) -> Result<Skin> {
        let Self { deformer, row } = self;
        let machine = &mut deformer.machine;
        let positions = machine.read_part::<[f32; 4]>(Resource::SkinPositions, *row)?;
        let normals = machine.read_part::<[f32; 4]>(Resource::SkinNormals, *row)?;
        let implicit = deformer.settings.method.has_fields();
        let (status, iso) = if implicit {
            (
                machine.read_part::<u32>(Resource::Status, *row)?,
                machine.read::<f32>(Resource::IsoValues)?,
            )
        } else {
            let none = deformer.statics.sizes.vertices as usize;
            (vec![0; none], vec![0.0; none])
        };
        let rig = &deformer.rig;
        let vertices = || rig.rows.vertex.iter().map(|v| *v as usize);
        let count = rig.rows.vertex.len();
        let vectors =
            |rows: &[[f32; 4]]| rows[..count].iter().map(|x| Vec3::from_slice(x)).collect();
        Ok(Skin {
            positions: vectors(&positions),
            normals: vectors(&normals),
            field: positions[..count].iter().map(|p| p[3]).collect(),
            iso: vertices()
                .map(|v| followed_iso(status[v], iso[v]))
                .collect(),
            state: vertices()
                .zip(&normals)
                .map(|(v, n)| match n[3] {
                    0.0 => reported_state(status[v], iso[v], implicit && !rig.geometric[v]),
                    _ => state::PAST_LIMIT as u8,
                })
                .collect(),
            bone: vertices().map(|v| rig.part[v]).collect(),
        })
    }

    /// Forgets its tracked skin: its next pose is reached from rest, whatever came before. For cuts. Nothing else than tracking
    /// has such a state.
    ///
    /// # Errors
    /// Vulkan errors.
    pub fn reset(&mut self) -> Result<()> {
        if self.deformer.settings.method == Method::Tracking {
            let rest = TrackedState::rest(&self.deformer.rig);
            self.put(&rest)?;
        }
        Ok(())
    }

    /// The state that its next frame goes on from; none for methods other than tracking. Waits for the last frame.
    ///
    /// # Errors
    /// Vulkan errors.
    pub fn save(&mut self) -> Result<Option<TrackedState>> {
        let Self { deformer, row } = self;
        if deformer.settings.method != Method::Tracking {
            return Ok(None);
        }
        let skin = &deformer.tracking.skins[*row];
        skin.check()?;
        let machine = &mut deformer.machine;
        Ok(Some(TrackedState {
            pose: skin.pose().cloned(),
            tracked: machine.read_part(Resource::Tracked, *row)?,
            before: machine.read_part(Resource::TrackedBefore, *row)?,
            slopes: machine.read_part(Resource::TrackedSlopes, *row)?,
            corrections: machine.read_part(Resource::Corrections, *row)?,
            around: machine.read_part(Resource::Around, *row)?,
        }))
    }

    /// Goes on from a saved state, of this instance or another one.
    ///
    /// # Errors
    /// [`Error::Argument`] with subject `state` where the method is not tracking or the state is another character's;
    /// Vulkan errors.
    pub fn restore(&mut self, state: &TrackedState) -> Result<()> {
        if self.deformer.settings.method != Method::Tracking {
            return Err(Error::argument("state", "only tracking has one"));
        }
        if !state.fits(&self.deformer.rig) {
            return Err(Error::argument("state", "it is of another character"));
        }
        self.put(state)
    }

    fn put(&mut self, state: &TrackedState) -> Result<()> {
        let Self { deformer, row } = self;
        let machine = &mut deformer.machine;
        let skin = &mut deformer.tracking.skins[*row];
        machine.wait()?;
        skin.broken = true;
        machine.write_part(Resource::Tracked, *row, &state.tracked)?;
        machine.write_part(Resource::TrackedBefore, *row, &state.before)?;
        machine.write_part(Resource::TrackedSlopes, *row, &state.slopes)?;
        machine.write_part(Resource::Corrections, *row, &state.corrections)?;
        machine.write_part(Resource::Around, *row, &state.around)?;
        skin.set(state.pose.as_ref());
        skin.broken = false;
        Ok(())
    }
}

/// A vertex that follows no field has no iso-value either.
fn followed_iso(status: u32, iso: f32) -> f32 {
    let untouched = state::of(status) == state::UNTOUCHED;
    if untouched { 0.0 } else { iso }
}

/// Vertices that no field reaches at rest are outside; the frame never lists them.
fn reported_state(status: u32, iso: f32, implicit: bool) -> u8 {
    let state = state::of(status);
    if implicit && state == state::UNTOUCHED && !statics::reached(iso) {
        state::OUTSIDE as u8
    } else {
        state as u8
    }
}
