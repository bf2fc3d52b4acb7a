use crate::map::{Occupancy, Snapshot, entropy};
use crate::sensor::Frame;
use crate::visibility::{Ray, Sight};

/// What the rays of a view are worth together: the view's information gain, not negative.
///
/// The rays of a view are added one by one, in a fixed order, to a tally that starts as its default.
///
/// ```
/// use nextview::gain::{InformationGain, UnobservedVoxel};
/// # use glam::{IVec3, UVec3};
/// # use nextview::geometry::{Lattice, VoxelBlock};
/// # use nextview::map::Snapshot;
/// use nextview::visibility::{Crossing, Ray, RayEnd};
///
/// # let block = VoxelBlock::new(IVec3::ZERO, UVec3::splat(2)).unwrap();
/// # let unknown = Snapshot::from_fn(Lattice::new(0.01).unwrap(), block, |_| None);
/// let gain = UnobservedVoxel::new(&unknown, &[]);
/// let mut tally = 0.0;
/// let crossings = [Crossing { voxel: 0, visibility: 1.0 }, Crossing { voxel: 1, visibility: 0.5 }];
/// gain.add(&Ray { crossings: &crossings, end: RayEnd::LeftBox }, &mut tally);
/// assert_eq!(UnobservedVoxel::total(&tally), 1.5 * std::f64::consts::LN_2);
/// ```
pub trait InformationGain: Sync + Sized {
    /// The rays that the formula needs.
    const SIGHT: Sight;

    /// What is kept of the rays so far.
    type Tally: Default;

    /// The gain under what the snapshot knows, which comes from these frames.
    fn new(snapshot: &Snapshot, frames: &[Frame]) -> Self;

    /// Adds a ray of the view.
    fn add(&self, ray: &Ray<'_>, tally: &mut Self::Tally);

    /// The gain of the view whose rays were added; 0 if there were none.
    fn total(tally: &Self::Tally) -> f64;
}

/// The entropy of every voxel, nats.
pub(super) fn entropies(snapshot: &Snapshot) -> Vec<f64> {
    snapshot.probability().iter().map(|&p| entropy(p as f64)).collect()
}

/// Whether each voxel was never measured.
pub(super) fn unknown(snapshot: &Snapshot) -> Vec<bool> {
    snapshot.occupancy().iter().map(|&state| state == Occupancy::Unknown).collect()
}
