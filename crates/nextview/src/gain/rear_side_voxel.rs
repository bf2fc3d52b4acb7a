use super::InformationGain;
use super::information_gain::unknown;
use crate::map::Snapshot;
use crate::sensor::Frame;
use crate::visibility::{FreeSpace, Ray, RayEnd, Sight};
use crate::{Cancel, Cancelled};

/// Rear side voxel volumetric information (Isler et al., ICRA 2016): the number of rays that reach a known
/// surface from behind, ending at an occupied voxel straight after an unknown one.
///
/// A voxel counts once for each ray that ends at it.
#[derive(Clone, Debug)]
pub struct RearSideVoxel {
    unknown: Vec<bool>,
}

impl InformationGain for RearSideVoxel {
    const SIGHT: Sight = Sight::endless(FreeSpace::Clear);

    type Tally = u64;

    fn new(snapshot: &Snapshot, _: &[Frame], _: &Cancel) -> Result<Self, Cancelled> {
        Ok(Self { unknown: unknown(snapshot) })
    }

    fn add(&self, ray: &Ray<'_>, count: &mut u64) {
        let from_unknown = ray.crossings.last().is_some_and(|last| self.unknown[last.voxel as usize]);
        *count += (from_unknown && matches!(ray.end, RayEnd::Occupied(_))) as u64;
    }

    fn total(count: &u64) -> f64 {
        *count as f64
    }
}
