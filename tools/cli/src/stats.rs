//! Order statistics of timings.

use serde::Serialize;

/// Least, middle and 95th percentile of a set of times, in milliseconds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub(crate) struct Spread {
    /// Least.
    pub(crate) min: f64,
    /// Median.
    pub(crate) p50: f64,
    /// 95th percentile (nearest rank).
    pub(crate) p95: f64,
}

impl Spread {
    /// Of times in nanoseconds; all zero for no times.
    pub(crate) fn of_ns(times: &[u64]) -> Self {
        let mut sorted = times.to_vec();
        sorted.sort_unstable();
        // Nearest rank: the least value with at least `share` of all values at or below it.
        let rank = |share: f64| {
            let rank = (share * sorted.len() as f64).ceil() as usize;
            sorted
                .get(rank.max(1) - 1)
                .map_or(0.0, |&ns| ns as f64 / 1e6)
        };
        Self {
            min: rank(0.0),
            p50: rank(0.5),
            p95: rank(0.95),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn percentiles_are_values_of_the_set() {
        let times: Vec<u64> = (1..=100).rev().map(|ms| ms * 1_000_000).collect();
        let spread = Spread::of_ns(&times);
        for (got, expected) in [(spread.min, 1.0), (spread.p50, 50.0), (spread.p95, 95.0)] {
            assert!((got - expected).abs() < 1e-9, "{spread:?}");
        }
        assert_eq!(Spread::of_ns(&[]), Spread::default());
    }
}
