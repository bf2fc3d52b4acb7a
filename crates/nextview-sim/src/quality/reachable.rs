use super::TrueSurface;
use crate::camera::Look;
use std::sync::atomic::{AtomicBool, Ordering};

/// A sample of the surface is seen if its pixel measures the object as near to it as this, metres.
const SEEN: f64 = 0.002;

/// The samples of a [`TrueSurface`] that any view candidate sees: the part of it that a model can have.
#[derive(Debug, Default)]
pub struct ReachableSurface {
    /// By sample. Views are added by several threads; as they only set, their order does not show.
    is_seen: Vec<AtomicBool>,
}

impl ReachableSurface {
    /// Nothing of the surface is known to be reachable.
    pub fn new(surface: &TrueSurface) -> Self {
        Self::of(surface.samples().iter().map(|_| false))
    }

    /// The samples, in the order of the surface's, that are reachable.
    pub fn of(is_seen: impl IntoIterator<Item = bool>) -> Self {
        Self { is_seen: is_seen.into_iter().map(AtomicBool::new).collect() }
    }

    /// Adds the samples that a look shows: those whose nearest pixel measures the object within 2 mm of them
    /// along its ray. The surface must be the one it was made for.
    pub fn add(&self, surface: &TrueSurface, look: &Look<'_>) {
        for (sample, is_seen) in surface.samples().iter().zip(&self.is_seen) {
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
