use crate::geometry::{Aabb, Plane, Pose};
use crate::map::{MapUpdate, Occupancy, Snapshot};
use crate::planner::{Choice, Outlook};
use crate::registration::Registration;
use crate::{Cancel, Cancelled};
use serde::{Deserialize, Serialize};

/// One step of a scan: the choice of a view and the changes of the map by the frame taken there.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct StepReport {
    /// Number of views taken so far, this one included.
    pub step: usize,
    /// Number of the view; none if it was no candidate: a first view without a number, or a frame that was
    /// not asked for.
    pub view: Option<usize>,
    /// Camera pose used for the map: with registration, the corrected pose; the given one if the frame was
    /// set aside.
    pub world_from_camera: Pose,
    /// Result of the alignment of the frame; none without registration, and for the first frame that shows
    /// the object.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub registration: Option<Registration>,
    /// How far the same surface is apart in the given poses, root mean square along its normal, metres, if
    /// this frame shows that they are wrong, so that all frames have been aligned and those to come will be;
    /// else `None`.
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
    /// Numbers, among all observed frames and from 0, of those that had been set aside and came into the map
    /// with this one.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub recovered: Vec<usize>,
    /// Why the view was chosen; none for the first.
    pub choice: Option<Choice>,
    /// The planner's expectations of the view and of all that could follow; none for planners without
    /// expectations.
    pub outlook: Option<Outlook>,
    /// Straight distance from where the last frame was taken, metres; 0 for the first.
    #[serde(rename = "travel_m")]
    pub travel: f64,
    /// Voxel size, metres, in which the view was planned; for a view that was not planned, that in which
    /// planning continues.
    #[serde(rename = "voxel_size_m")]
    pub voxel_size: f64,
    /// The box around the object after the frame; none if no object was found.
    pub bounds: Option<Aabb>,
    /// The table that the object stands on; none without one, or if none was found.
    pub table: Option<Plane>,
    /// Share, 0..=1, of the voxels with measured surface whose expected error is within the
    /// [goal](super::SessionConfig::goal) and that were seen as often as
    /// [wanted](super::SessionConfig::looks); none without such goals.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub share_at_goal: Option<f64>,
    /// The changes that the frame made in the map, with those of the recovered ones.
    pub update: MapUpdate,
    /// The known state of the box after it.
    pub map: MapReport,
}

/// The known state of the box around the object, in the finest voxels; zeros if there is none.
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
    /// The same as a share, 0..=1, of an unknown box: the value that eq. (9) compares with q_thresh.
    pub entropy_share: f64,
}

impl MapReport {
    /// Counts a snapshot.
    pub fn new(snapshot: &Snapshot) -> Self {
        Self::unless(snapshot, &Cancel::default()).expect("nobody cancels")
    }

    /// [`new`](Self::new), unless cancelled.
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
