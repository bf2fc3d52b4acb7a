use crate::geometry::Pose;
use crate::map::{MapUpdate, Occupancy, Snapshot};
use crate::planner::{Choice, FlowSummary};
use serde::{Deserialize, Serialize};

/// Everything worth telling about one step: the choice of a view and what looking from there changed.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct StepReport {
    /// Number of views taken so far, this one included.
    pub step: usize,
    /// Number of the view; none if the frame was not asked for.
    pub view: Option<usize>,
    /// Where the camera stood.
    pub world_from_camera: Pose,
    /// Why the view was chosen; none for the first.
    pub choice: Option<Choice>,
    /// The flow behind the choice, for planners that solve one.
    pub flow: Option<FlowSummary>,
    /// What the frame changed in the map.
    pub update: MapUpdate,
    /// The box around the object after it.
    pub map: MapReport,
}

/// What is known of the box around the object.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct MapReport {
    /// Occupied voxels.
    pub n_occupied: usize,
    /// Free voxels.
    pub n_free: usize,
    /// Voxels never measured.
    pub n_unknown: usize,
    /// Entropy of the box, nats: the paper's eq. (8).
    pub entropy: f64,
    /// The same as a share, 0..=1, of an unknown box: what eq. (9) compares with q_thresh.
    pub entropy_share: f64,
}

impl MapReport {
    /// Counts a snapshot.
    pub fn new(snapshot: &Snapshot) -> Self {
        Self {
            n_occupied: snapshot.count(Occupancy::Occupied),
            n_free: snapshot.count(Occupancy::Free),
            n_unknown: snapshot.count(Occupancy::Unknown),
            entropy: snapshot.entropy(),
            entropy_share: snapshot.entropy_share(),
        }
    }
}
