use crate::camera::Look;
use glam::DVec3;
use std::sync::atomic::{AtomicBool, Ordering};

/// A surface sample is seen if its pixel measures the object within this distance, metres.
const SEEN: f64 = 0.002;

/// The samples of a [true surface](super::TrueSurface) that any view candidate sees: the part a model can
/// have.
#[derive(Debug, Default)]
pub struct ReachableSurface {
    /// By sample. Several threads add views; their order does not matter, since they only set flags.
    is_seen: Vec<AtomicBool>,
}

impl ReachableSurface {
    /// Creates a set of `n_samples` samples, none of them known to be reachable.
    pub fn new(n_samples: usize) -> Self {
        Self::of(std::iter::repeat_n(false, n_samples))
    }

    /// Creates a set from a flag for each sample, in the surface's order.
    pub fn of(is_seen: impl IntoIterator<Item = bool>) -> Self {
        Self { is_seen: is_seen.into_iter().map(AtomicBool::new).collect() }
    }

    /// Adds the samples visible in a look: those whose nearest pixel measures the object within 2 mm along
    /// its ray.
    pub fn add(&self, samples: &[DVec3], look: &Look<'_>) {
        for (sample, is_seen) in samples.iter().zip(&self.is_seen) {
            if !is_seen.load(Ordering::Relaxed) && look.shows(*sample, SEEN) {
                is_seen.store(true, Ordering::Relaxed);
            }
        }
    }

    /// Returns whether the sample with this number is reachable.
    pub fn contains(&self, sample: usize) -> bool {
        self.is_seen[sample].load(Ordering::Relaxed)
    }
}
