use crate::patches::{FEWEST, Patches};
use glam::DVec3;
use nextview::registration::SurfacePoint;
use nextview_sim::accuracy::SurfaceDistance;
use rayon::prelude::*;

/// The deviation of the surface around a point from the model: the mean over its patch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Deviation {
    /// Metres, positive outside the model.
    pub mean: f64,
    /// Standard error of the mean, metres; infinite for a patch with few points.
    pub error: f64,
}

/// The deviations of all points.
pub(crate) struct Deviations {
    /// The deviation of each point.
    pub of_points: Vec<Deviation>,
    /// Median error that neighbouring points share, metres: a depth camera's surface is wavy, and averaging
    /// over a patch does not remove waves.
    pub correlated_error: f64,
}

/// The verdict on a point for a tolerance.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum PointVerdict {
    /// The deviation exceeds the tolerance.
    Deviates,
    /// The deviation is within the tolerance.
    Within,
    /// The noise is too large to decide.
    Uncertain,
}

/// Minimum cosine between the normals of a patch: across an edge lies another surface.
const AGREEMENT: f64 = 0.5;

/// Number of standard errors by which a deviation must exceed the tolerance, or be below it, to be certain.
const SURE: f64 = 3.0;

impl Deviation {
    pub fn verdict(self, tolerance: f64) -> PointVerdict {
        match self.mean.abs() {
            mean if mean - SURE * self.error > tolerance => PointVerdict::Deviates,
            mean if mean + SURE * self.error <= tolerance => PointVerdict::Within,
            _ => PointVerdict::Uncertain,
        }
    }
}

/// The deviation at each point, in the coordinates of the model.
///
/// The size of the waves depends on distance and slope. Waves are assumed to be proportional to the expected
/// errors of the points, in metres, or constant if those are unknown.
pub(crate) fn deviations(
    points: &[SurfacePoint],
    expected: &[Option<f64>],
    positions: &[DVec3],
    surface: &SurfaceDistance,
    patches: &Patches<'_>,
) -> Deviations {
    let alone: Vec<f64> = positions.par_iter().map(|position| surface.signed_at(*position)).collect();
    let deviation = |point: &SurfacePoint| {
        let of_patch = patches.around(point.position);
        let values = of_patch.filter(|i| points[*i].normal.dot(point.normal) >= AGREEMENT).map(|i| alone[i]);
        mean(&values.collect::<Vec<f64>>())
    };
    let mut of_points: Vec<Deviation> = points.par_iter().map(deviation).collect();
    let known = median(expected.iter().flatten().copied());
    let usual = if known > 0.0 { known } else { 1.0 };
    let sizes: Vec<f64> = expected.iter().map(|error| error.unwrap_or(usual)).collect();
    let factor = correlated_factor(&of_points, &sizes);
    of_points.iter_mut().zip(&sizes).for_each(|(of, size)| of.error = of.error.hypot(factor * size));
    Deviations { of_points, correlated_error: factor * median(sizes.into_iter()) }
}

/// The ratio of a normal distribution's standard deviation to its median absolute deviation.
const NORMAL: f64 = 1.4826;

/// Factor by which to multiply `sizes` to get the spread of the deviations that their standard errors do not
/// explain. It is computed from medians, so defects do not count.
fn correlated_factor(deviations: &[Deviation], sizes: &[f64]) -> f64 {
    let known = || deviations.iter().zip(sizes).filter(|(deviation, _)| deviation.error.is_finite());
    let middle = median(known().map(|(deviation, _)| deviation.mean));
    let spread = NORMAL * median(known().map(|(deviation, size)| (deviation.mean - middle).abs() / size));
    let explained = median(known().map(|(deviation, size)| deviation.error / size));
    (spread.powi(2) - explained.powi(2)).max(0.0).sqrt()
}

/// The median; 0 if there are no values.
fn median(values: impl Iterator<Item = f64>) -> f64 {
    let mut sorted: Vec<f64> = values.collect();
    sorted.sort_by(f64::total_cmp);
    sorted.get(sorted.len() / 2).copied().unwrap_or(0.0)
}

fn mean(values: &[f64]) -> Deviation {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    if values.len() < FEWEST {
        return Deviation { mean, error: f64::INFINITY };
    }
    let variance = values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / (n - 1.0);
    Deviation { mean, error: (variance / n).sqrt() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_patches_do_not_explain_is_common_to_their_points() {
        let waves = |amplitude: f64, size: fn(i32) -> f64| -> Vec<Deviation> {
            let mean = |i: i32| amplitude * size(i) * f64::from(i).sin();
            (0..1000).map(|i| Deviation { mean: mean(i), error: 0.1 * size(i) }).collect()
        };
        let even = |amplitude| correlated_factor(&waves(amplitude, |_| 1.0), &[1.0; 1000]);
        assert_eq!(even(0.05), 0.0);
        assert!((even(2.0) - 2.0).abs() < 0.2, "{}", even(2.0));
        assert_eq!(correlated_factor(&[], &[]), 0.0);

        let size: fn(i32) -> f64 = |i| 1.0 + f64::from(i / 500);
        let sizes: Vec<f64> = (0..1000).map(size).collect();
        let factor = correlated_factor(&waves(2.0, size), &sizes);
        assert!((factor - even(2.0)).abs() < 1e-2, "as large as they are expected to be: {factor}");
    }

    #[test]
    fn a_patch_is_sure_where_its_noise_is_small() {
        let quiet = mean(&[1.0, 1.1, 0.9, 1.0, 1.0, 1.05]);
        assert!((quiet.mean - 1.0083).abs() < 1e-4 && (quiet.error - 0.0271).abs() < 1e-3, "{quiet:?}");
        assert_eq!(
            [0.5, 1.0, 1.2].map(|t| quiet.verdict(t)),
            [PointVerdict::Deviates, PointVerdict::Uncertain, PointVerdict::Within]
        );
        assert_eq!(mean(&[1.0; 4]).verdict(0.1), PointVerdict::Uncertain, "few points");
    }
}
