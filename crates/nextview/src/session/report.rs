use crate::geometry::{Aabb, Plane, Pose};
use crate::map::{MapUpdate, Occupancy, Snapshot};
use crate::planner::{Choice, Outlook};
use crate::registration::Registration;
use crate::{Cancel, Cancelled};
use serde::{Deserialize, Serialize};

/// One step of a scan: the choice of a view, and the changes to the map by its frame.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct StepReport {
    /// Number of views taken so far, this one included.
    pub step: usize,
    /// Number of the view; `None` if it is not a candidate: a first view without a number, or an unrequested
    /// frame.
    pub view: Option<usize>,
    /// Camera pose used for the map: the corrected pose with registration, the given one if the frame was set
    /// aside.
    pub world_from_camera: Pose,
    /// Result of the frame's alignment; `None` if registration is off, and for the first frame that shows the
    /// object.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub registration: Option<Registration>,
    /// How far apart the given poses put the same surface, root mean square along its normal, metres, if this
    /// frame proves them wrong: all frames have been aligned, and later ones will be. `None` otherwise.
    #[serde(default, rename = "apart_m", skip_serializing_if = "Option::is_none")]
    pub apart: Option<f64>,
    /// Whether alignment was given up with this frame, since it failed for most: all poses, also of earlier
    /// frames, are used as given. Only with
    /// [`RegistrationMode::Auto`](crate::registration::RegistrationMode).
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub is_as_given: bool,
    /// Whether the frame could not be aligned and is not in the map.
    #[serde(default)]
    pub is_set_aside: bool,
    /// Numbers (from 0, among all observed frames) of the frames that were set aside and entered the map with
    /// this one.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub recovered: Vec<usize>,
    /// The reason for the choice of the view; `None` for the first.
    pub choice: Option<Choice>,
    /// The planner's expectations of the view and of all that could follow; `None` if the planner has none.
    pub outlook: Option<Outlook>,
    /// Straight distance from the last frame's camera position, metres; 0 for the first.
    #[serde(rename = "travel_m")]
    pub travel: f64,
    /// Voxel size, metres, in which the view was planned; if it was not planned, the size in which planning
    /// continues.
    #[serde(rename = "voxel_size_m")]
    pub voxel_size: f64,
    /// The object's box after the frame; `None` if no object was found.
    pub bounds: Option<Aabb>,
    /// The table under the object; `None` if there is no table, or if it was not found.
    pub table: Option<Plane>,
    /// Share, 0..=1, of the voxels with measured surface that reach the goals for
    /// [accuracy](super::SessionConfig::goal) and [looks](super::SessionConfig::looks); `None` if there are
    /// no such goals.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub share_at_goal: Option<f64>,
    /// The changes made to the map by the frame and the recovered ones.
    pub update: MapUpdate,
    /// The known state of the box after the frame.
    pub map: MapReport,
}

/// The known state of the object's box, in the finest voxels; zeros if there is none.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct MapReport {
    /// Occupied voxels.
    pub n_occupied: usize,
    /// Free voxels.
    pub n_free: usize,
    /// Voxels never measured.
    pub n_unknown: usize,
    /// Entropy of the box, nats: the paper's eq. (8).
    #[serde(rename = "entropy_nats")]
    pub entropy: f64,
    /// Entropy as a share, 0..=1, of that of an unknown box: the value that eq. (9) compares with q_thresh.
    pub entropy_share: f64,
}

impl MapReport {
    /// Counts a snapshot.
    pub fn new(snapshot: &Snapshot) -> Self {
        Self::unless(snapshot, &Cancel::default()).expect("nobody cancels")
    }

    /// As [`new`](Self::new), unless cancelled.
    pub(super) fn unless(snapshot: &Snapshot, cancel: &Cancel) -> Result<Self, Cancelled> {
        let [n_occupied, n_free] = [Occupancy::Occupied, Occupancy::Free].map(|state| snapshot.count(state));
        cancel.check()?;
        let entropy = snapshot.entropy_unless(cancel)?;
        Ok(Self {
            n_occupied,
            n_free,
            n_unknown: snapshot.block().n_voxels() - n_occupied - n_free,
            entropy,
            entropy_share: snapshot.share_of_unknown(entropy),
        })
    }
}
