//! The area under a coverage curve: one number for the amount and speed of coverage, from 0 (nothing, ever)
//! to 1 (everything at once).

/// Returns the mean coverage, 0..=1, after each of `n` views. A shorter curve keeps its last value. `None` if
/// the curve is empty or `n` is 0.
pub fn over_views(coverage: &[f64], n: usize) -> Option<f64> {
    let last = *coverage.last()?;
    let sum: f64 = (0..n).map(|i| coverage.get(i).copied().unwrap_or(last)).sum();
    (n > 0).then(|| sum / n as f64)
}

/// Returns the mean coverage, 0..=1, over the time from 0 to a horizon, seconds. Coverage is 0 until the
/// first view and holds between views and after the last. `times`, seconds, are non-decreasing, one per
/// value. `None` if the curve is empty or the horizon is not positive.
pub fn over_time(coverage: &[f64], times: &[f64], horizon: f64) -> Option<f64> {
    assert_eq!(coverage.len(), times.len(), "a time for each value");
    let ends = times.iter().skip(1).copied().chain([horizon]);
    let area: f64 = coverage
        .iter()
        .zip(times.iter().zip(ends))
        .map(|(share, (start, end))| share * (end.min(horizon) - start).max(0.0))
        .sum();
    (!coverage.is_empty() && horizon > 0.0).then(|| area / horizon)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn over_views_it_is_the_mean_and_an_early_end_keeps_its_coverage() {
        assert_eq!(over_views(&[0.2, 0.6, 0.7], 3), Some(0.5));
        assert_eq!(over_views(&[0.5, 1.0], 4), Some(0.875));
        assert_eq!(over_views(&[0.5, 1.0], 1), Some(0.5), "views beyond the limit do not count");
        assert_eq!((over_views(&[], 3), over_views(&[1.0], 0)), (None, None));
    }

    #[test]
    fn over_time_it_is_the_mean_over_moments() {
        let (coverage, times) = ([0.25, 0.5, 0.75], [2.0, 4.0, 7.0]);
        for horizon in [1.0, 3.0, 6.5, 7.0, 20.0] {
            let at =
                |t: f64| coverage.iter().zip(times).rfind(|(_, start)| *start <= t).map_or(0.0, |(c, _)| *c);
            let n = 20_000;
            let mean = (0..n).map(|i| at(horizon * (i as f64 + 0.5) / n as f64)).sum::<f64>() / n as f64;
            let area = over_time(&coverage, &times, horizon).unwrap();
            assert!((area - mean).abs() < 1e-4, "{horizon}: {area} {mean}");
        }
        assert_eq!((over_time(&[], &[], 1.0), over_time(&[1.0], &[0.0], 0.0)), (None, None));
    }
}
