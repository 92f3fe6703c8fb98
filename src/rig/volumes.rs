//! Volumes of a rig's operators, kept in its cache where they take long.

use std::{convert::Infallible, sync::OnceLock};

use super::{
    Rig,
    cache::{self, Entry, Key},
};
use crate::{
    Error, Result,
    compose::{Operator, Profile, Volume, profile_volume, volume},
};

/// The contact's volume, which all rigs share.
static CONTACT: OnceLock<Volume> = OnceLock::new();

impl Rig {
    /// An operator's volume in implicit skinning, with this rig's magnitude.
    ///
    /// A bulge takes ten times as long to sample as to read, so that it is kept in the rig's cache, where there is one,
    /// and sampled anew where the file there cannot be trusted; one that cannot be written is left.
    pub fn volume(&self, operator: Operator) -> Volume {
        let magnitude = self.composition.magnitude;
        if operator != Operator::Bulge {
            return volume(operator, magnitude);
        }
        let key = Key::builder("bulge").pods(&[magnitude]).finish();
        let Ok(kept) = self.kept(&key, || Ok::<_, Infallible>(volume(operator, magnitude)));
        kept
    }

    /// An operator's volume in tracking, by its profile: contact where it is neither a bulge nor the user's profile.
    ///
    /// # Errors
    /// [`Error::Argument`] with subject `magnitude` or `profile` where the operator cannot be made.
    pub fn tracking_volume(&self, operator: Operator) -> Result<Volume> {
        let composition = &self.composition;
        let profile = match (operator, &composition.profile) {
            (Operator::Bulge, _) => Profile::bulge(composition.magnitude)?,
            (Operator::Profile, Some(profile)) => profile.clone(),
            _ => {
                if let Some(made) = CONTACT.get() {
                    return Ok(made.clone());
                }
                let key = Key::builder("contact").finish();
                let made = self.kept(&key, || profile_volume(&Profile::contact()))?;
                return Ok(CONTACT.get_or_init(|| made).clone());
            }
        };
        let text = serde_json::to_string(&profile);
        let text = text.map_err(|e| Error::argument("profile", e.to_string()))?;
        let key = Key::builder("profile").text(&text).finish();
        self.kept(&key, || profile_volume(&profile))
    }

    /// A volume from the rig's cache, or made and put there.
    fn kept<E>(&self, key: &Key, make: impl FnOnce() -> Result<Volume, E>) -> Result<Volume, E> {
        let Some(dir) = &self.cache else {
            return make();
        };
        if let Entry::Found(bytes) = cache::load(dir, key)
            && let Ok(kept) = Volume::from_bytes(&bytes)
        {
            return Ok(kept);
        }
        let made = make()?;
        // The preparation has said whether the folder can be written.
        let _ = cache::store(dir, key, made.bytes());
        Ok(made)
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use std::fs;

    use super::*;

    #[test]
    fn a_bulge_is_kept_by_magnitude_and_made_anew_where_it_is_damaged() {
        let dir = tempfile::tempdir().unwrap();
        let rig = |magnitude| {
            let mut rig = Rig {
                cache: Some(dir.path().into()),
                ..Rig::default()
            };
            rig.composition.magnitude = magnitude;
            rig
        };
        let files = || fs::read_dir(dir.path()).unwrap().count();
        assert_eq!(
            rig(1.0).volume(Operator::Blend),
            volume(Operator::Blend, 1.0)
        );
        assert_eq!(files(), 0, "a blend is quick");
        let made = volume(Operator::Bulge, 1.0);
        assert!(rig(1.0).volume(Operator::Bulge) == made);
        assert_eq!(files(), 1);
        let entry = fs::read_dir(dir.path()).unwrap().next().unwrap();
        let path = entry.unwrap().path();
        let (whole, written) = (fs::read(&path).unwrap(), modified(&path));
        assert!(rig(1.0).volume(Operator::Bulge) == made);
        assert_eq!(modified(&path), written, "it was read");
        let mut damaged = whole.clone();
        damaged[whole.len() / 2] ^= 1;
        fs::write(&path, damaged).unwrap();
        assert!(rig(1.0).volume(Operator::Bulge) == made);
        assert!(fs::read(&path).unwrap() == whole, "it was mended");
        assert!(rig(0.5).volume(Operator::Bulge) != made);
        assert_eq!(files(), 2);
    }

    fn modified(path: &std::path::Path) -> std::time::SystemTime {
        fs::metadata(path).unwrap().modified().unwrap()
    }
}
