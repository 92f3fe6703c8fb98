//! Order statistics of timings.

use serde::Serialize;

/// Least, middle, 95th percentile and mean of a set of times, in milliseconds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub(crate) struct Spread {
    /// Least.
    pub(crate) min: f64,
    /// Median.
    pub(crate) p50: f64,
    /// 95th percentile (nearest rank).
    pub(crate) p95: f64,
    /// Mean without the values above twice the 95th percentile: threads that were taken off their cores. Of frames that
    /// differ, means add up, medians do not.
    pub(crate) mean: f64,
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
        let p95 = rank(0.95);
        let usual = sorted.iter().map(|&ns| ns as f64 / 1e6);
        let usual: Vec<f64> = usual.filter(|ms| *ms <= 2.0 * p95).collect();
        Self {
            min: rank(0.0),
            p50: rank(0.5),
            p95,
            mean: usual.iter().sum::<f64>() / usual.len().max(1) as f64,
        }
    }

    /// The share of one of so many.
    pub(crate) fn over(self, count: u32) -> Self {
        let share = |ms| ms / f64::from(count.max(1));
        Self {
            min: share(self.min),
            p50: share(self.p50),
            p95: share(self.p95),
            mean: share(self.mean),
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
        for (got, expected) in [
            (spread.min, 1.0),
            (spread.p50, 50.0),
            (spread.p95, 95.0),
            (spread.mean, 50.5),
        ] {
            assert!((got - expected).abs() < 1e-9, "{spread:?}");
        }
        assert_eq!(Spread::of_ns(&[]), Spread::default());
    }
}
