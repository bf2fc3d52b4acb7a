use crate::map::Snapshot;
use crate::sensor::{Frame, Intrinsics};
use crate::view::ViewSpace;
use glam::DVec3;
use serde::{Deserialize, Serialize};

/// Chooses the next view. Pure: the same situation gives the same plan.
pub trait ViewPlanner: Send {
    /// Ranks the views not yet visited and picks one; none if no view gains anything.
    fn plan(&self, situation: &Situation<'_>) -> Plan;
}

/// All that a planner may know.
#[derive(Clone, Copy, Debug)]
pub struct Situation<'a> {
    /// What is known of the box around the object.
    pub snapshot: &'a Snapshot,
    /// The frames it is known from, oldest first; none where only a map is left of them.
    pub frames: &'a [Frame],
    /// Where the camera could go.
    pub views: &'a ViewSpace,
    /// The optics of the camera that will go there.
    pub intrinsics: &'a Intrinsics,
    /// The views taken so far, in order.
    pub visited: &'a [usize],
    /// The optimal views (the paper's V_global) of the earlier plans, oldest first.
    pub history: &'a [Vec<u32>],
    /// Voxel size in which the scan ends, metres: that of the snapshot, or finer. Distances between rays are in voxels
    /// of this size, so that plans in coarser voxels have as many rays: ten coarse voxels may be wider than the box.
    pub finest_voxel_size: f64,
}

impl Situation<'_> {
    /// The views within reach and not yet visited, in increasing order.
    pub fn open_views(&self) -> Vec<usize> {
        let mut is_open: Vec<bool> =
            (0..self.views.len()).map(|view| self.views.is_within_reach(view)).collect();
        self.visited.iter().for_each(|&view| is_open[view] = false);
        (0..is_open.len()).filter(|&view| is_open[view]).collect()
    }

    /// Where the camera is, metres: where it took the last frame, or else the last view; none before the first.
    pub fn camera_position(&self) -> Option<DVec3> {
        let last_frame = self.frames.last().map(|frame| frame.world_from_camera());
        let pose = last_frame.or_else(|| self.visited.last().map(|&view| self.views.pose(view)));
        pose.map(|pose| pose.translation())
    }

    /// A distance in voxels of the finest size as one in voxels of the snapshot.
    pub(super) fn in_snapshot_voxels(&self, distance: f64) -> f64 {
        distance * (self.finest_voxel_size / self.snapshot.lattice().voxel_size())
    }
}

/// A planner's answer.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Plan {
    /// The next best view and why; none if no view gains anything.
    pub choice: Option<Choice>,
    /// The views that together would serve every voxel best (V_global), in increasing order; empty for planners
    /// without a flow.
    pub optimal_views: Vec<u32>,
    /// The flow behind them.
    pub flow: Option<FlowSummary>,
    /// Where to go after the choice without another plan, for planners that choose several views at once.
    pub itinerary: Option<Itinerary>,
    /// What the planner expects of the next view and of all, for planners that tell.
    pub outlook: Option<Outlook>,
}

/// What a planner expects to be seen.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Outlook {
    /// Number of voxels that are occupied so far, of the size the planner thinks in.
    pub n_seen: usize,
    /// How many the chosen view is expected to add.
    pub n_expected: f64,
    /// How many are expected to be seen if every view were taken.
    pub n_unseen: f64,
}

impl Outlook {
    /// The estimated share, 0..=1, of what can be seen that has been seen; 1 if nothing can.
    pub fn completeness(&self) -> f64 {
        let n_seen = self.n_seen as f64;
        if n_seen + self.n_unseen > 0.0 { n_seen / (n_seen + self.n_unseen) } else { 1.0 }
    }

    /// What the chosen view is expected to add, as a share of what was seen; infinite if nothing was.
    pub fn gain(&self) -> f64 {
        if self.n_seen > 0 { self.n_expected / self.n_seen as f64 } else { f64::INFINITY }
    }
}

/// Views that were chosen together, in the order of the tour.
///
/// It holds as long as the camera sees what was expected: after that, its views were chosen for a map that is no more.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Itinerary {
    /// The views, the first of which is the choice of the plan.
    pub legs: Vec<Leg>,
    /// How far what is seen may be from what was expected, as a share of that, at least 0.
    pub tolerance: f64,
}

/// A view of an itinerary.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Leg {
    /// The view and why it was chosen.
    pub choice: Choice,
    /// How many voxels it is expected to make newly occupied after those before it, up to a factor that is about the
    /// same for all legs and plans; positive.
    pub expected: f64,
}

/// A view and why it was chosen.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Choice {
    /// Number of the view.
    pub view: usize,
    /// What the planner maximised.
    pub score: f64,
    /// The view's share of all local gain, 0..=1 (eq. 6, first fraction), or of that of a greedy planner; zero for
    /// planners without one.
    pub local_share: f64,
    /// The view's share of all flow gain, 0..=1 (eq. 6, second fraction); zero for planners without one.
    pub flow_share: f64,
    /// The second best view.
    pub runner_up: Option<usize>,
}

/// The maximum flow of the paper's eq. (3).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct FlowSummary {
    /// Number of voxels served: f_S.
    pub n_voxels: usize,
    /// Largest total quality Q_T, nats.
    pub quality: f64,
    /// Number of views that carry flow.
    pub n_views: usize,
}

#[cfg(test)]
mod tests {
    use super::*;

    fn outlook(n_seen: usize, n_expected: f64, n_unseen: f64) -> Outlook {
        Outlook { n_seen, n_expected, n_unseen }
    }

    #[test]
    fn completeness_is_the_share_seen() {
        assert_eq!(outlook(90, 0.0, 10.0).completeness(), 0.9);
        assert_eq!(outlook(90, 0.0, 0.0).completeness(), 1.0);
        assert_eq!(outlook(0, 0.0, 10.0).completeness(), 0.0);
        assert_eq!(outlook(0, 0.0, 0.0).completeness(), 1.0, "nothing can be seen");
    }

    #[test]
    fn gain_is_a_share_of_what_was_seen() {
        assert_eq!(outlook(80, 20.0, 10.0).gain(), 0.25);
        assert_eq!(outlook(80, 0.0, 10.0).gain(), 0.0);
        assert_eq!(outlook(0, 20.0, 30.0).gain(), f64::INFINITY);
        assert_eq!(outlook(0, 0.0, 0.0).gain(), f64::INFINITY, "a number, even of nothing");
    }
}
