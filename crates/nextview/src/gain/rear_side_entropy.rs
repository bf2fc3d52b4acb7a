use super::InformationGain;
use super::information_gain::{entropies, unknown};
use crate::map::Snapshot;
use crate::sensor::Frame;
use crate::visibility::{FreeSpace, Ray, RayEnd, Sight};
use crate::{Cancel, Cancelled};

/// Rear side entropy (Isler et al., ICRA 2016; Delmerico et al., Autonomous Robots 2018): over the rays that
/// end at an occupied voxel straight after an unknown one, the sum of P(vis_x) H(x) over that occupied voxel
/// and the unbroken run of unknown voxels before it, nats.
///
/// Faded rays continue, although visibility is a factor: only the end of a ray decides whether it counts. The
/// authors' code multiplies P(occupied) into the visibility; here it is 1 - P(occupied), as published.
#[derive(Clone, Debug)]
pub struct RearSideEntropy {
    entropy: Vec<f64>,
    unknown: Vec<bool>,
}

impl InformationGain for RearSideEntropy {
    const SIGHT: Sight = Sight::endless(FreeSpace::Fades);

    type Tally = f64;

    fn new(snapshot: &Snapshot, _: &[Frame], cancel: &Cancel) -> Result<Self, Cancelled> {
        Ok(Self { entropy: entropies(snapshot, cancel)?, unknown: unknown(snapshot) })
    }

    fn add(&self, ray: &Ray<'_>, sum: &mut f64) {
        let RayEnd::Occupied(surface) = ray.end else { return };
        let n_measured =
            ray.crossings.iter().rposition(|x| !self.unknown[x.voxel as usize]).map_or(0, |i| i + 1);
        let run = &ray.crossings[n_measured..];
        if run.is_empty() {
            return;
        }
        for crossing in run.iter().chain([&surface]) {
            *sum += crossing.visibility as f64 * self.entropy[crossing.voxel as usize];
        }
    }

    fn total(sum: &f64) -> f64 {
        *sum
    }
}
