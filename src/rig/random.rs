//! A small generator of reproducible numbers (SplitMix64: Steele, Lea & Flood 2014).

use glam::Vec3;

/// A stream of numbers that depends on nothing but its seed.
#[derive(Clone, Debug)]
pub struct Random(u64);

impl Random {
    /// A stream.
    pub fn new(seed: u64) -> Self {
        Self(seed)
    }

    /// The next 64 bits.
    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// A number in [0, 1), evenly.
    pub fn unit(&mut self) -> f64 {
        (self.bits() >> 11) as f64 / (1u64 << 53) as f64
    }

    /// A unit vector, evenly over the sphere.
    pub fn direction(&mut self) -> Vec3 {
        loop {
            let mut cube = || (self.unit() * 2.0 - 1.0) as f32;
            let v = Vec3::new(cube(), cube(), cube());
            if (1e-4..=1.0).contains(&v.length_squared()) {
                return v.normalize();
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_stream_is_splitmix64() {
        // Reference values of the published algorithm for seed 1234567.
        let mut random = Random::new(1_234_567);
        assert_eq!(random.bits(), 6_457_827_717_110_365_317);
        assert_eq!(random.bits(), 3_203_168_211_198_807_973);
    }

    #[test]
    fn directions_have_no_bias() {
        let mut random = Random::new(3);
        let mean = (0..4000).map(|_| random.direction()).sum::<Vec3>() / 4000.0;
        assert!(mean.length() < 0.03, "{mean}");
    }
}
