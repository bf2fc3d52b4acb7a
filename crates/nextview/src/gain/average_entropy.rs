use super::InformationGain;
use super::information_gain::entropies;
use crate::map::Snapshot;
use crate::sensor::Frame;
use crate::visibility::{FreeSpace, Ray, RayEnd, Sight};
use crate::{Cancel, Cancelled};

/// The average entropy of Kriegel et al. (Journal of Real-Time Image Processing 2015): over the rays that end
/// at an occupied voxel, the sum of H(x) divided by the number of all their x, nats, at most ln 2.
///
/// This is one mean over the voxels of all rays, not a mean of the rays' means. The occupied voxel counts; a
/// voxel counts once for each ray that crosses it.
#[derive(Clone, Debug)]
pub struct AverageEntropy {
    entropy: Vec<f64>,
}

impl InformationGain for AverageEntropy {
    // Fading affects only the extent of the rays: the mean has no visibility, but includes the free voxels at
    // the margin of the box.
    const SIGHT: Sight = Sight::endless(FreeSpace::Fades);

    /// Sum and number.
    type Tally = (f64, u64);

    fn new(snapshot: &Snapshot, _: &[Frame], cancel: &Cancel) -> Result<Self, Cancelled> {
        Ok(Self { entropy: entropies(snapshot, cancel)? })
    }

    fn add(&self, ray: &Ray<'_>, (sum, number): &mut (f64, u64)) {
        let RayEnd::Occupied(surface) = ray.end else { return };
        for crossing in ray.crossings.iter().chain([&surface]) {
            *sum += self.entropy[crossing.voxel as usize];
        }
        *number += ray.crossings.len() as u64 + 1;
    }

    fn total(&(sum, number): &(f64, u64)) -> f64 {
        if number == 0 { 0.0 } else { sum / number as f64 }
    }
}
