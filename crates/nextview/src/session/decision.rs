use crate::geometry::Pose;
use crate::planner::{Choice, Outlook, Plan};
use serde::{Deserialize, Serialize};

/// The next action.
#[derive(Clone, Debug, PartialEq)]
pub enum Decision {
    /// Go there and observe.
    Move(NextView),
    /// The scan is over.
    Stop(StopReason),
}

/// The next best view.
#[derive(Clone, Debug, PartialEq)]
pub struct NextView {
    /// Its number in the view space; none for a first view that is no candidate.
    pub view: Option<usize>,
    /// Where the camera should stand.
    pub world_from_camera: Pose,
    /// Why it was chosen; none for the first view, which is given.
    pub choice: Option<Choice>,
    /// The planner's expectations of the view and of all that could follow; none for planners without
    /// expectations.
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
    /// The entropy in the box fell below the stated share: the paper's eq. (9).
    Converged,
    /// No candidate gains anything.
    NothingToGain,
    /// The required share of the surface is estimated to have been seen.
    Complete,
    /// The last views together added less than required.
    NoProgress,
    /// The next view is expected to add less than required.
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
    /// The box around everything connected to the object needs more memory than allowed, for example because
    /// of a table or wall that it touches.
    BoxTooLarge,
    /// The robot [can go](super::Session::set_approaches) to no further candidate, at least from where it is.
    OutOfReach,
    /// Whoever drives the scan ended it. Never decided by a session.
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
