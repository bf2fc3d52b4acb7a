use super::InformationGain;
use super::information_gain::entropies;
use super::object_probability::from_nearest;
use crate::map::{Snapshot, frontier};
use crate::sensor::Frame;
use crate::visibility::{FreeSpace, Ray, Sight};
use crate::{Cancel, Cancelled};

/// The gain of APORA (Daudelin & Campbell, RA-L 2017) as stated by Pan & Wei (2021): the sum over the unknown
/// x of all rays of H(x) P(obj_x) and the product of 1 - P(obj) over the voxels before x, nats.
///
/// P(obj_x) = exp(-(alpha d)^2) with d the distance to the nearest frontier voxel and alpha = 0.1 / voxel
/// size; it is 0 for measured voxels, so free space hides nothing. Occupied voxels end a ray. Without a
/// frontier, P(obj) of the unknown voxels is 1 if no occupied voxel was seen yet, else 0, as for the paper's
/// own gain.
#[derive(Clone, Debug)]
pub struct Apora {
    entropy: Vec<f64>,
    object: Vec<f64>,
}

impl InformationGain for Apora {
    const SIGHT: Sight = Sight::endless(FreeSpace::Clear);

    type Tally = f64;

    fn new(snapshot: &Snapshot, _: &[Frame], cancel: &Cancel) -> Result<Self, Cancelled> {
        Ok(Self {
            entropy: entropies(snapshot, cancel)?,
            object: from_nearest::<1>(snapshot, &frontier(snapshot), cancel)?,
        })
    }

    fn add(&self, ray: &Ray<'_>, sum: &mut f64) {
        let mut unhidden = 1.0;
        for crossing in ray.crossings {
            let object = self.object[crossing.voxel as usize];
            *sum += self.entropy[crossing.voxel as usize] * object * unhidden;
            unhidden *= 1.0 - object;
        }
    }

    fn total(sum: &f64) -> f64 {
        *sum
    }
}
