//! Serialization of the truth: bits of every view, and of the reachable surface.

use super::{SimulatedObject, Truth};
use fixedbitset::FixedBitSet;
use nextview_sim::quality::ReachableSurface;
use nextview_sim::truth::TrueVisibility;
use std::sync::Arc;
use std::time::Duration;

/// Bytes of a block of bits.
const BLOCK: usize = size_of::<usize>();

impl Truth {
    /// Serializes the truth of this object, without the time taken to compute it.
    pub(super) fn to_bytes(&self, object: &SimulatedObject) -> Vec<u8> {
        let views = (0..self.visibility.n_views()).map(|view| self.visibility.seen(view));
        let mut bytes: Vec<u8> = views.flat_map(bytes_of).collect();
        let mut surface = FixedBitSet::with_capacity(object.true_surface.samples().len());
        (0..surface.len()).for_each(|sample| surface.set(sample, self.reachable_surface.contains(sample)));
        bytes.extend(bytes_of(&surface));
        bytes
    }

    /// Reads the bytes that [`to_bytes`](Self::to_bytes) made for this object; `None` if they cannot be its
    /// truth.
    pub(super) fn of_bytes(object: &SimulatedObject, bytes: &[u8], time: Duration) -> Option<Self> {
        if bytes.len() != n_bytes(object) || object.object_voxels.is_empty() {
            return None;
        }
        let (n_voxels, n_samples) = (object.object_voxels.len(), object.true_surface.samples().len());
        let (views, surface) = bytes.split_at(object.views.len() * n_voxels.div_ceil(8));
        let seen = views.chunks_exact(n_voxels.div_ceil(8)).map(|view| bits_of(view, n_voxels));
        let visibility = TrueVisibility::of_seen(seen.collect())?;
        Some(Self {
            reachable_voxels: visibility.reachable().clone(),
            visibility: Arc::new(visibility),
            reachable_surface: ReachableSurface::of(
                (0..n_samples).map(|i| surface[i / 8] >> (i % 8) & 1 == 1),
            ),
            time,
        })
    }
}

/// Size of the truth of this object in bytes.
pub(super) fn n_bytes(object: &SimulatedObject) -> usize {
    let (n_voxels, n_samples) = (object.object_voxels.len(), object.true_surface.samples().len());
    object.views.len() * n_voxels.div_ceil(8) + n_samples.div_ceil(8)
}

/// Packs bits, lowest bit of a byte first, on every machine.
fn bytes_of(bits: &FixedBitSet) -> Vec<u8> {
    let blocks = bits.as_slice().iter().flat_map(|block| block.to_le_bytes());
    blocks.take(bits.len().div_ceil(8)).collect()
}

fn bits_of(bytes: &[u8], n_bits: usize) -> FixedBitSet {
    let block = |bytes: &[u8]| {
        let mut block = [0; BLOCK];
        block[..bytes.len()].copy_from_slice(bytes);
        usize::from_le_bytes(block)
    };
    FixedBitSet::with_capacity_and_blocks(n_bits, bytes.chunks(BLOCK).map(block))
}
