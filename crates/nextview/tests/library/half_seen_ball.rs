#![allow(clippy::unwrap_used, reason = "helpers of tests")]

use glam::{IVec3, UVec3};
use nextview::geometry::{Lattice, VoxelBlock};
use nextview::map::{LogOdds, Snapshot};

/// A ball whose +x side was measured, with free space around that side; the rest is unknown.
pub fn half_seen_ball() -> Snapshot {
    let block = VoxelBlock::new(IVec3::splat(-8), UVec3::splat(16)).unwrap();
    let lattice = Lattice::new(0.01).unwrap();
    Snapshot::from_fn(lattice, block, |key| {
        let center = lattice.center(key);
        let radius = center.length();
        match center.x > 0.0 {
            true if (0.04..0.052).contains(&radius) => Some(LogOdds(0.85)),
            true if radius >= 0.052 => Some(LogOdds(-0.4)),
            _ => None,
        }
    })
}
