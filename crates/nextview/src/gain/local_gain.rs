use super::object_probability;
use crate::map::{Snapshot, entropy, frontier};
use crate::visibility::Crossing;
use crate::{Cancel, Cancelled};

/// The paper's local information gain, eqs. (1) and (2): the sum of entropy, visibility and object
/// probability, H(x) P(vis_x) P(obj_x), over the unknown voxels that a view's rays cross, nats.
#[derive(Clone, Debug)]
pub struct LocalGain {
    /// H(x) P(obj_x) of every voxel: the factors that do not depend on the view.
    weights: Vec<f64>,
}

impl LocalGain {
    /// Creates the gain for a snapshot.
    ///
    /// Fails if `cancel` is set.
    pub fn new(snapshot: &Snapshot, cancel: &Cancel) -> Result<Self, Cancelled> {
        let object = object_probability(snapshot, &frontier(snapshot), cancel)?;
        // Measured voxels have weight 0, and an unknown voxel usually has the entropy of its neighbour:
        // computing every logarithm would take longer than everything else here.
        let (mut last, mut last_entropy) = (f32::NAN, 0.0);
        let weight = |(&object, &p): (&f64, &f32)| {
            if object > 0.0 && p != last {
                (last, last_entropy) = (p, entropy(p as f64));
            }
            if object > 0.0 { last_entropy * object } else { 0.0 }
        };
        cancel.check()?;
        Ok(Self { weights: object.iter().zip(snapshot.probability()).map(weight).collect() })
    }

    /// H(x) P(obj_x) of every voxel of the snapshot: its quality if fully visible, 0 for measured voxels.
    pub(crate) fn weights(&self) -> &[f64] {
        &self.weights
    }

    /// Returns the quality Q of a voxel seen along a ray, H(x) P(vis_x) P(obj_x): a summand of eq. (1), and
    /// the weight of the edge between voxel and ray in the flow network.
    pub fn quality(&self, crossing: &Crossing) -> f64 {
        self.weights[crossing.voxel as usize] * crossing.visibility as f64
    }
}
