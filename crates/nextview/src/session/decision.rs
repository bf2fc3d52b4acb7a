use crate::geometry::Pose;
use crate::planner::{Choice, Outlook, Plan};
use serde::{Deserialize, Serialize};

/// The next action.
#[derive(Clone, Debug, PartialEq)]
pub enum Decision {
    /// Move to this view and observe a frame.
    Move(NextView),
    /// The scan is over.
    Stop(StopReason),
}

/// The next best view.
#[derive(Clone, Debug, PartialEq)]
pub struct NextView {
    /// Its number in the view space; `None` for a first view that is not a candidate.
    pub view: Option<usize>,
    /// The camera pose to take.
    pub world_from_camera: Pose,
    /// The reason for the choice; `None` for the first view, which is given.
    pub choice: Option<Choice>,
    /// The planner's expectations of the view and of all that could follow; `None` if the planner has none.
    pub outlook: Option<Outlook>,
}

/// Why a scan ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum StopReason {
    /// The maximum number of views was taken.
    ViewLimit,
    /// The entropy in the box fell below the configured share: the paper's eq. (9).
    Converged,
    /// No candidate gains anything.
    NothingToGain,
    /// The required share of the surface is estimated to have been seen.
    Complete,
    /// The last views together added less surface than required.
    NoProgress,
    /// The next view is expected to add less surface than required.
    LittleToGain,
    /// The next view would make the path longer than allowed.
    PathLimit,
    /// The time limit was reached. A session reads no clock: its caller decides this.
    TimeLimit,
    /// The decision was [cancelled](crate::Cancel). It is not stored: the next call decides again.
    Cancelled,
    /// There is no box to plan in: no frame shows an object yet, or the known box lies inside the table.
    /// After another frame, taken from elsewhere, the scan may continue.
    NoObject,
    /// The box around everything connected to the object exceeds the memory limit, for example because the
    /// object touches a table or wall.
    BoxTooLarge,
    /// The robot [can reach](super::Session::set_approaches) no further candidate, at least from its current
    /// pose.
    OutOfReach,
    /// The caller ended the scan. Never decided by a session.
    Ended,
}

impl Decision {
    /// Moves to a planned or given view.
    pub(super) fn go_to(view: Option<usize>, world_from_camera: Pose, plan: Plan) -> Self {
        let Plan { choice, outlook, .. } = plan;
        Self::Move(NextView { view, world_from_camera, choice, outlook })
    }

    pub(super) fn next_view(self) -> Option<NextView> {
        match self {
            Self::Move(next) => Some(next),
            Self::Stop(_) => None,
        }
    }
}
