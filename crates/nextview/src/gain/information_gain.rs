use crate::map::{Occupancy, Snapshot, entropy};
use crate::sensor::Frame;
use crate::visibility::{Ray, Sight};
use crate::{Cancel, Cancelled};

/// The information gain of a view, not negative: the joint value of its rays.
///
/// The rays of a view are added one by one, in a fixed order, to a tally that starts as its default.
///
/// ```
/// use nextview::Cancel;
/// use nextview::gain::{InformationGain, UnobservedVoxel};
/// # use glam::{IVec3, UVec3};
/// # use nextview::geometry::{Lattice, VoxelBlock};
/// # use nextview::map::Snapshot;
/// use nextview::visibility::{Crossing, Ray, RayEnd};
///
/// # let block = VoxelBlock::new(IVec3::ZERO, UVec3::splat(2)).unwrap();
/// # let unknown = Snapshot::from_fn(Lattice::new(0.01).unwrap(), block, |_| None);
/// let gain = UnobservedVoxel::new(&unknown, &[], &Cancel::default()).unwrap();
/// let mut tally = 0.0;
/// let crossings = [Crossing { voxel: 0, visibility: 1.0 }, Crossing { voxel: 1, visibility: 0.5 }];
/// gain.add(&Ray { crossings: &crossings, end: RayEnd::LeftBox }, &mut tally);
/// assert_eq!(UnobservedVoxel::total(&tally), 1.5 * std::f64::consts::LN_2);
/// ```
pub trait InformationGain: Sync + Sized {
    /// The rays that the formula needs.
    const SIGHT: Sight;

    /// Running totals over the rays added so far.
    type Tally: Default;

    /// Creates the gain for a snapshot that was made from these frames.
    ///
    /// Long computations check `cancel` and fail if it is set.
    fn new(snapshot: &Snapshot, frames: &[Frame], cancel: &Cancel) -> Result<Self, Cancelled>;

    /// Adds a ray of the view.
    fn add(&self, ray: &Ray<'_>, tally: &mut Self::Tally);

    /// Returns the gain of the view whose rays were added; 0 if there were none.
    fn total(tally: &Self::Tally) -> f64;
}

/// Voxels processed between two checks for cancellation.
const CHUNK: usize = 1 << 16;

/// Returns the entropy of every voxel, nats.
pub(super) fn entropies(snapshot: &Snapshot, cancel: &Cancel) -> Result<Vec<f64>, Cancelled> {
    let mut all = Vec::with_capacity(snapshot.probability().len());
    for part in snapshot.probability().chunks(CHUNK) {
        cancel.check()?;
        all.extend(part.iter().map(|&p| entropy(p as f64)));
    }
    Ok(all)
}

/// Returns, for every voxel, whether it was never measured.
pub(super) fn unknown(snapshot: &Snapshot) -> Vec<bool> {
    snapshot.occupancy().iter().map(|&state| state == Occupancy::Unknown).collect()
}
