use super::InformationGain;
use super::information_gain::{entropies, unknown};
use crate::map::Snapshot;
use crate::sensor::Frame;
use crate::visibility::{FreeSpace, Ray, Sight};
use crate::{Cancel, Cancelled};

/// Unobserved voxel volumetric information (Isler et al., ICRA 2016): the sum of P(vis_x) H(x) over the
/// unknown x of all rays, nats.
#[derive(Clone, Debug)]
pub struct UnobservedVoxel {
    /// The entropy of unknown voxels, 0 for others.
    entropy: Vec<f64>,
}

impl InformationGain for UnobservedVoxel {
    const SIGHT: Sight = Sight::endless(FreeSpace::Fades);

    type Tally = f64;

    fn new(snapshot: &Snapshot, _: &[Frame], cancel: &Cancel) -> Result<Self, Cancelled> {
        let all = entropies(snapshot, cancel)?.into_iter().zip(unknown(snapshot));
        Ok(Self { entropy: all.map(|(entropy, unknown)| if unknown { entropy } else { 0.0 }).collect() })
    }

    fn add(&self, ray: &Ray<'_>, sum: &mut f64) {
        for crossing in ray.crossings {
            *sum += crossing.visibility as f64 * self.entropy[crossing.voxel as usize];
        }
    }

    fn total(sum: &f64) -> f64 {
        *sum
    }
}
