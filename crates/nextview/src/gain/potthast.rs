use super::InformationGain;
use super::information_gain::entropies;
use crate::map::{Snapshot, entropy};
use crate::sensor::Frame;
use crate::visibility::{FreeSpace, Ray, RayEnd, Sight};
use crate::{Cancel, Cancelled};

/// The gain of Potthast & Sukhatme (Journal of Visual Communication and Image Representation 2014, eqs. 4 to
/// 15): the entropy that a view is expected to remove, nats, by a hidden Markov model along each ray.
///
/// The model follows two beliefs from voxel to voxel: v, that the camera still sees, and o, that the voxel is
/// occupied after it was observed. Where v falls, o returns to the occupancy p of the map. Hidden voxels thus
/// gain nothing, without a rule for when a voxel is hidden.
///
/// Voxels are counted from where the ray enters the box, since the map has none before. Both decays are per
/// metre: those of the publication in voxels of 1 cm, whatever the voxel size. A ray ends at the first
/// occupied voxel; eqs. (6) and (7) alone would hardly end it. The Markov random field by which the
/// publication fills in missing points is not part of the gain.
#[derive(Clone, Debug)]
pub struct Potthast {
    /// P(occupied) of every voxel, at least [`MARGIN`] away from 0 and 1.
    occupancy: Vec<f64>,
    entropy: Vec<f64>,
    /// Voxel size in voxels of the publication.
    scale: f64,
}

/// The published decay of sight, a: from voxel m - 1 to m, sight continues with probability a^m (eq. 9).
const DECAY: f64 = 0.999;

/// Probability that lost sight returns (eq. 10).
const RETURN: f64 = 1e-8;

/// Edge of the voxels for which the decay is published, metres.
const PUBLISHED_VOXEL_SIZE: f64 = 0.01;

/// Margin of P(occupied): no observation could change a certain voxel.
const MARGIN: f64 = 1e-6;

/// Sight below which a ray ends: the rest of it adds less than a thousandth.
const LEAST_SIGHT: f64 = 1e-3;

impl InformationGain for Potthast {
    // Free voxels move both beliefs, also those at the margin of the box.
    const SIGHT: Sight = Sight::endless(FreeSpace::Fades);

    type Tally = f64;

    fn new(snapshot: &Snapshot, _: &[Frame], cancel: &Cancel) -> Result<Self, Cancelled> {
        let occupancy = snapshot.probability().iter().map(|&p| (p as f64).clamp(MARGIN, 1.0 - MARGIN));
        Ok(Self {
            occupancy: occupancy.collect(),
            entropy: entropies(snapshot, cancel)?,
            scale: snapshot.lattice().voxel_size() / PUBLISHED_VOXEL_SIZE,
        })
    }

    fn add(&self, ray: &Ray<'_>, sum: &mut f64) {
        let last = match &ray.end {
            RayEnd::Occupied(last) => Some(last),
            RayEnd::LeftBox | RayEnd::Faded => None,
        };
        let decay = DECAY.powf(self.scale * self.scale);
        let (mut passes, mut v, mut o, mut p_before) = (1.0, 1.0, 0.0, 0.5);
        for crossing in ray.crossings.iter().chain(last) {
            let p = self.occupancy[crossing.voxel as usize];
            passes *= decay; // eq. (9)
            let v_predicted = passes * v + RETURN * (1.0 - v); // eq. (5)
            v = corrected(v_predicted, 1.0 - p_before); // eqs. (6), (7)
            let is_kept = 0.5 * (1.0 + v.powf(self.scale)); // eqs. (14), (15)
            let o_predicted = is_kept * o + (1.0 - is_kept) * (1.0 - o); // eq. (11)
            o = corrected(o_predicted, p); // eq. (12)
            *sum += self.entropy[crossing.voxel as usize] - entropy(o); // eq. (4)
            p_before = p;
            if v < LEAST_SIGHT {
                return;
            }
        }
    }

    fn total(sum: &f64) -> f64 {
        // An occupied voxel may become less certain than it was; such a view is worth nothing.
        sum.max(0.0)
    }
}

/// The belief in a state after evidence for it of this probability.
fn corrected(predicted: f64, evidence: f64) -> f64 {
    let (is, is_not) = (evidence * predicted, (1.0 - evidence) * (1.0 - predicted));
    is / (is + is_not)
}
