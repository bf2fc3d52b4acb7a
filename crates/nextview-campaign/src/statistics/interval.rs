use nextview::geometry::random::Random;
use serde::{Deserialize, Serialize};

/// Number of resamples for an interval: its ends then vary by about a hundredth of its width with the seed.
const N_RESAMPLES: usize = 10_000;

/// A 95 % interval, by the bootstrap (Efron 1979).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Interval {
    /// Lower end.
    pub low: f64,
    /// Upper end.
    pub high: f64,
}

impl Interval {
    /// Returns the interval of the mean of the values' population: the 2.5th to the 97.5th percentile of the
    /// means of resamples. For paired values, pass the differences.
    ///
    /// `None` for fewer than two values, which say nothing about their variation. Below about ten values the
    /// interval is too narrow. The same values in the same order always give the same interval.
    pub fn of_mean(values: &[f64]) -> Option<Self> {
        let n = values.len();
        let resampled = |random: &mut Random| (0..n).map(|_| values[random.index(n)]).sum::<f64>() / n as f64;
        (n > 1).then(|| Self::by_bootstrap(n, resampled))
    }

    /// The 2.5th to the 97.5th percentile of a number over many resamples of n objects. The same resampling
    /// always gives the same interval.
    pub(super) fn by_bootstrap(n: usize, mut resampled: impl FnMut(&mut Random) -> f64) -> Self {
        let mut random = Random::new(0, n as u64);
        let mut numbers: Vec<f64> = (0..N_RESAMPLES).map(|_| resampled(&mut random)).collect();
        numbers.sort_by(f64::total_cmp);
        Self { low: sorted_percentile(&numbers, 0.025), high: sorted_percentile(&numbers, 0.975) }
    }

    /// The interval of a normally distributed number with this mean and standard deviation.
    pub(super) fn of_normal(mean: f64, deviation: f64) -> Self {
        /// The 97.5th percentile of the standard normal distribution.
        const Z: f64 = 1.959_963_984_540_054;
        Self { low: mean - Z * deviation, high: mean + Z * deviation }
    }

    /// Returns whether a difference in this interval is more than noise. Rounding, about 1e-16 of the values,
    /// is noise.
    pub fn excludes_zero(&self) -> bool {
        self.excludes(0.0)
    }

    /// Returns whether the interval excludes `no_difference`: for a ratio, 1.
    pub fn excludes(&self, no_difference: f64) -> bool {
        self.low > no_difference + 1e-12 || self.high < no_difference - 1e-12
    }

    /// Applies an increasing function to the interval.
    pub fn map(self, f: impl Fn(f64) -> f64) -> Self {
        Self { low: f(self.low), high: f(self.high) }
    }
}

/// Returns the mean; `None` for no values.
pub fn mean(values: &[f64]) -> Option<f64> {
    (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
}

/// Returns the standard deviation of the values' population; `None` for fewer than two values.
pub fn deviation(values: &[f64]) -> Option<f64> {
    let mean = mean(values).filter(|_| values.len() > 1)?;
    let sum: f64 = values.iter().map(|value| (value - mean).powi(2)).sum();
    Some((sum / (values.len() - 1) as f64).sqrt())
}

/// Returns the value below which this share (0..=1) of the values lies, linear between neighbours; `None` for
/// no values.
pub fn percentile(values: &[f64], share: f64) -> Option<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    (!sorted.is_empty()).then(|| sorted_percentile(&sorted, share))
}

fn sorted_percentile(sorted: &[f64], share: f64) -> f64 {
    let at = share * (sorted.len() - 1) as f64;
    let (below, above) = (sorted[at.floor() as usize], sorted[at.ceil() as usize]);
    below + (above - below) * at.fract()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_values() {
        assert_eq!(mean(&[]), None);
        assert_eq!(mean(&[1.0, 2.0, 6.0]), Some(3.0));
        assert_eq!((deviation(&[1.0]), deviation(&[1.0, 2.0, 3.0])), (None, Some(1.0)));
        assert_eq!(percentile(&[], 0.5), None);
        assert_eq!(percentile(&[3.0, 1.0, 2.0], 0.5), Some(2.0));
        assert_eq!(percentile(&[4.0, 1.0, 2.0, 3.0], 0.5), Some(2.5));
        assert_eq!(percentile(&[0.0, 10.0], 0.95), Some(9.5));
        assert_eq!(Interval::of_mean(&[5.0]), None);
        assert_eq!(Interval::of_mean(&[5.0; 7]), Some(Interval { low: 5.0, high: 5.0 }));
        assert!(!Interval { low: -1e-16, high: 1.0 }.excludes_zero());
        assert!(Interval { low: -1.0, high: -0.1 }.excludes_zero());
    }

    /// The means of all n^n resamples.
    fn all_means(values: &[f64]) -> Vec<f64> {
        let n = values.len();
        let resample = |code: usize| (0..n).map(move |i| values[code / n.pow(i as u32) % n]).sum::<f64>();
        (0..n.pow(n as u32)).map(|code| resample(code) / n as f64).collect()
    }

    #[test]
    fn resampling_agrees_with_all_resamples() {
        for values in [vec![0.0, 1.0, 5.0, 2.5, 3.1], vec![-1.0, 0.3, 0.2, 0.9, 4.0, 4.2, 1.1]] {
            let interval = Interval::of_mean(&values).unwrap();
            let means = all_means(&values);
            let exact = [0.025, 0.975].map(|share| percentile(&means, share).unwrap());
            // The ends of 10 000 resamples have a standard error of about 0.02 standard deviations.
            assert!((interval.low - exact[0]).abs() < 0.08, "{interval:?} {exact:?}");
            assert!((interval.high - exact[1]).abs() < 0.08, "{interval:?} {exact:?}");
            assert_eq!(Interval::of_mean(&values), Some(interval));
        }
    }

    #[test]
    fn about_95_of_100_intervals_hold_the_true_mean() {
        let mut random = Random::new(7, 0);
        let holds = |_: &usize| {
            // The sum of twelve uniform numbers is nearly normal with mean 6.
            let draw = |_| (0..12).map(|_| random.unit()).sum::<f64>();
            let values: Vec<f64> = (0..40).map(draw).collect();
            let Interval { low, high } = Interval::of_mean(&values).unwrap();
            (low..high).contains(&6.0)
        };
        let n_holding = (0..300).filter(holds).count();
        // Expected 282 (94 %, since the bootstrap is a little narrow for 40 values), standard deviation 4.
        assert!((270..=296).contains(&n_holding), "{n_holding}");
    }
}
