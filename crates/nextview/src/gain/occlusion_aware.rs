use super::InformationGain;
use super::information_gain::entropies;
use crate::map::Snapshot;
use crate::sensor::Frame;
use crate::visibility::{FreeSpace, Ray, RayEnd, Sight};
use crate::{Cancel, Cancelled};

/// Occlusion aware volumetric information (Isler et al., ICRA 2016): the sum of P(vis_x) H(x) over all x of
/// all rays, nats.
///
/// The occupied voxel at which a ray ends counts. The authors' code multiplies P(occupied) into the
/// visibility; here it is 1 - P(occupied), as published.
#[derive(Clone, Debug)]
pub struct OcclusionAware {
    entropy: Vec<f64>,
}

impl InformationGain for OcclusionAware {
    const SIGHT: Sight = Sight::endless(FreeSpace::Fades);

    type Tally = f64;

    fn new(snapshot: &Snapshot, _: &[Frame], cancel: &Cancel) -> Result<Self, Cancelled> {
        Ok(Self { entropy: entropies(snapshot, cancel)? })
    }

    fn add(&self, ray: &Ray<'_>, sum: &mut f64) {
        let last = match &ray.end {
            RayEnd::Occupied(last) => Some(last),
            RayEnd::LeftBox | RayEnd::Faded => None,
        };
        for crossing in ray.crossings.iter().chain(last) {
            *sum += crossing.visibility as f64 * self.entropy[crossing.voxel as usize];
        }
    }

    fn total(sum: &f64) -> f64 {
        *sum
    }
}
