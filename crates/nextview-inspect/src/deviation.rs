use crate::patches::{FEWEST, Patches};
use glam::DVec3;
use nextview::registration::SurfacePoint;
use nextview_sim::accuracy::SurfaceDistance;
use rayon::prelude::*;

/// How far the surface around a point is from the model: the mean over its patch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Deviation {
    /// Metres, positive outside of the model.
    pub mean: f64,
    /// Its standard error, metres; infinite of a patch of few points.
    pub error: f64,
}

/// The deviations of all points.
pub(crate) struct Deviations {
    /// Of each.
    pub of_points: Vec<Deviation>,
    /// The part of all errors that neighbouring points have in common, metres: a depth camera's surface is
    /// wavy, and averaging over a patch does not help.
    pub correlated_error: f64,
}

/// The verdict on a point, for a tolerance.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Verdict {
    /// It deviates by more.
    Deviates,
    /// It does not.
    Within,
    /// Noise hides which of both.
    Uncertain,
}

/// Least cosine between the normals of a patch: around an edge, another side is another surface.
const AGREEMENT: f64 = 0.5;

/// Standard errors that a deviation must be above the tolerance, or below it, to be sure.
const SURE: f64 = 3.0;

impl Deviation {
    pub fn verdict(self, tolerance: f64) -> Verdict {
        match self.mean.abs() {
            mean if mean - SURE * self.error > tolerance => Verdict::Deviates,
            mean if mean + SURE * self.error <= tolerance => Verdict::Within,
            _ => Verdict::Uncertain,
        }
    }
}

/// The deviation at each point, in the coordinates of the model.
pub(crate) fn deviations(
    points: &[SurfacePoint],
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
    let correlated_error = correlated_error(&of_points);
    of_points.iter_mut().for_each(|of| of.error = of.error.hypot(correlated_error));
    Deviations { of_points, correlated_error }
}

/// The standard deviation of a normal distribution over its median absolute deviation.
const NORMAL: f64 = 1.4826;

/// How much more deviations vary than their standard errors explain; of most points, so that defects do not
/// count.
fn correlated_error(deviations: &[Deviation]) -> f64 {
    let known = || deviations.iter().filter(|deviation| deviation.error.is_finite());
    let middle = median(known().map(|deviation| deviation.mean));
    let spread = NORMAL * median(known().map(|deviation| (deviation.mean - middle).abs()));
    let explained = median(known().map(|deviation| deviation.error));
    (spread.powi(2) - explained.powi(2)).max(0.0).sqrt()
}

/// 0 without values.
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
        let waves = |amplitude: f64| -> Vec<Deviation> {
            (0..1000).map(|i| Deviation { mean: amplitude * f64::from(i).sin(), error: 0.1 }).collect()
        };
        assert_eq!(correlated_error(&waves(0.05)), 0.0);
        assert!((correlated_error(&waves(2.0)) - 2.0).abs() < 0.2, "{}", correlated_error(&waves(2.0)));
        assert_eq!(correlated_error(&[]), 0.0);
    }

    #[test]
    fn a_patch_is_sure_where_its_noise_is_small() {
        let quiet = mean(&[1.0, 1.1, 0.9, 1.0, 1.0, 1.05]);
        assert!((quiet.mean - 1.0083).abs() < 1e-4 && (quiet.error - 0.0271).abs() < 1e-3, "{quiet:?}");
        assert_eq!(
            [0.5, 1.0, 1.2].map(|t| quiet.verdict(t)),
            [Verdict::Deviates, Verdict::Uncertain, Verdict::Within]
        );
        assert_eq!(mean(&[1.0; 4]).verdict(0.1), Verdict::Uncertain, "few points");
    }
}
