use super::InformationGain;
use super::information_gain::entropies;
use crate::map::Snapshot;
use crate::sensor::Frame;
use crate::visibility::{FreeSpace, Ray, RayEnd, Sight};
use crate::{Cancel, Cancelled};

/// The gain of Krainin, Curless & Fox (ICRA 2011) as stated by Pan & Wei (2021): the sum of H(x) over all x
/// of the rays that end at an occupied voxel, nats.
///
/// The occupied voxel counts; rays that leave the box count nothing.
#[derive(Clone, Debug)]
pub struct Krainin {
    entropy: Vec<f64>,
}

impl InformationGain for Krainin {
    // Fading affects only the extent of the rays: the sum has no visibility, but includes the free voxels at
    // the margin of the box.
    const SIGHT: Sight = Sight::endless(FreeSpace::Fades);

    type Tally = f64;

    fn new(snapshot: &Snapshot, _: &[Frame], cancel: &Cancel) -> Result<Self, Cancelled> {
        Ok(Self { entropy: entropies(snapshot, cancel)? })
    }

    fn add(&self, ray: &Ray<'_>, sum: &mut f64) {
        let RayEnd::Occupied(surface) = ray.end else { return };
        for crossing in ray.crossings.iter().chain([&surface]) {
            *sum += self.entropy[crossing.voxel as usize];
        }
    }

    fn total(sum: &f64) -> f64 {
        *sum
    }
}
