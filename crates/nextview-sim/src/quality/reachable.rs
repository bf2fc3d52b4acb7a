use crate::camera::Look;
use glam::DVec3;
use std::sync::atomic::{AtomicBool, Ordering};

/// A sample of the surface is seen if its pixel measures the object as near to it as this, metres.
const SEEN: f64 = 0.002;

/// The samples of a [true surface](super::TrueSurface) that any view candidate sees: the part of it that a
/// model can have.
#[derive(Debug, Default)]
pub struct ReachableSurface {
    /// By sample. Views are added by several threads; as they only set, their order does not show.
    is_seen: Vec<AtomicBool>,
}

impl ReachableSurface {
    /// None of so many samples is known to be reachable.
    pub fn new(n_samples: usize) -> Self {
        Self::of(std::iter::repeat_n(false, n_samples))
    }

    /// The samples, in the order of the surface's, that are reachable.
    pub fn of(is_seen: impl IntoIterator<Item = bool>) -> Self {
        Self { is_seen: is_seen.into_iter().map(AtomicBool::new).collect() }
    }

    /// Adds the samples that a look shows: those whose nearest pixel measures the object within 2 mm of them
    /// along its ray.
    pub fn add(&self, samples: &[DVec3], look: &Look<'_>) {
        for (sample, is_seen) in samples.iter().zip(&self.is_seen) {
            if !is_seen.load(Ordering::Relaxed) && look.shows(*sample, SEEN) {
                is_seen.store(true, Ordering::Relaxed);
            }
        }
    }

    /// Whether the sample with this number is reachable.
    pub fn contains(&self, sample: usize) -> bool {
        self.is_seen[sample].load(Ordering::Relaxed)
    }
}
