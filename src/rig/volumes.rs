//! Volumes of a rig's operators, kept in its cache where they take long.

use super::{
    Rig,
    cache::{self, Entry, Key},
};
use crate::compose::{EDGE, Operator, Volume, volume};

impl Rig {
    /// An operator's volume, with this rig's magnitude.
    ///
    /// A bulge takes ten times as long to sample as to read, so that it is kept in the rig's cache, where there is one,
    /// and sampled anew where the file there cannot be trusted; one that cannot be written is left.
    pub fn volume(&self, operator: Operator) -> Volume {
        let magnitude = self.composition.magnitude;
        let (Some(dir), Operator::Bulge) = (&self.cache, operator) else {
            return volume(operator, magnitude);
        };
        let key = Key::builder("bulge").pods(&[magnitude]).finish();
        if let Entry::Found(bytes) = cache::load(dir, &key)
            && bytes.len() == EDGE * EDGE * EDGE * 8
        {
            return Volume {
                texels: bytemuck::pod_collect_to_vec(&bytes),
            };
        }
        let made = volume(operator, magnitude);
        // The preparation has said whether the folder can be written.
        let _ = cache::store(dir, &key, made.bytes());
        made
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
