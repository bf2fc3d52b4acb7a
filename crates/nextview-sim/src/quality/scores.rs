use crate::accuracy::Accuracy;

/// The distances, metres, within which points and surface count as matched.
pub const TOLERANCES: [f64; 3] = [0.001, 0.002, 0.005];

/// Accuracy and completeness of a model against the true surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quality {
    /// From the model's points to the true surface.
    pub accuracy: Accuracy,
    /// Share, 0..=1, of the model's points within each of the [`TOLERANCES`] of the true surface.
    pub precision: [f64; 3],
    /// From the true surface, all of it, to the model.
    pub completeness: Completeness,
    /// From the reachable part of the true surface to the model; `None` if that part is not known.
    pub reachable: Option<Completeness>,
}

/// Distances of surface samples, uniform by area, from a model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Completeness {
    /// Share, 0..=1, of samples within each of the [`TOLERANCES`].
    pub within: [f64; 3],
    /// Mean distance, metres.
    pub mean: f64,
}

impl Quality {
    /// Returns the share, 0..=1, of the reachable surface covered by the model, for each of the
    /// [`TOLERANCES`]; `None` if that surface is not known.
    pub fn recall(&self) -> Option<[f64; 3]> {
        Some(self.reachable?.within)
    }

    /// Returns the harmonic mean of precision and recall, 0..=1, for each of the [`TOLERANCES`]; `None` if
    /// there is no recall.
    pub fn f_score(&self) -> Option<[f64; 3]> {
        let recall = self.recall()?;
        Some(std::array::from_fn(|i| harmonic_mean(self.precision[i], recall[i])))
    }

    /// Returns the Chamfer distance, metres: the mean of the mean distances from the model to the true
    /// surface and from the reachable surface to the model. `None` if the reachable surface is not known.
    pub fn chamfer(&self) -> Option<f64> {
        Some(0.5 * (self.accuracy.mean + self.reachable?.mean))
    }
}

impl Completeness {
    /// Evaluates these sample distances, metres; `None` if there are none.
    pub(super) fn of(distances: &[f64]) -> Option<Self> {
        let n = distances.len() as f64;
        let mean = distances.iter().sum::<f64>() / n;
        (n > 0.0).then(|| Self { within: TOLERANCES.map(|limit| share_within(distances, limit)), mean })
    }
}

pub(super) fn share_within(distances: &[f64], limit: f64) -> f64 {
    distances.iter().filter(|distance| **distance <= limit).count() as f64 / distances.len() as f64
}

fn harmonic_mean(a: f64, b: f64) -> f64 {
    if a + b > 0.0 { 2.0 * a * b / (a + b) } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_found_and_nothing_right_is_a_score_of_zero() {
        assert_eq!(
            (harmonic_mean(0.0, 0.0), harmonic_mean(0.0, 1.0), harmonic_mean(1.0, 0.5)),
            (0.0, 0.0, 2.0 / 3.0)
        );
    }
}
