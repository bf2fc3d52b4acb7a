use super::{Session, StopConfig, StopReason, goal};
use crate::Cancelled;
use crate::map::Snapshot;
use crate::planner::Plan;

/// When a scan ends.
impl Session {
    /// Returns the reason not to plan another view, if any.
    pub(super) fn stops_before_planning(&self) -> Option<StopReason> {
        if self.n_taken >= self.config.max_views {
            return Some(StopReason::ViewLimit);
        }
        if self.scene.is_box_too_large {
            return Some(StopReason::BoxTooLarge);
        }
        let has_stalled = self.scene.map.is_finest() && self.planner.seeks_surface() && self.has_stalled();
        has_stalled.then_some(StopReason::NoProgress)
    }

    /// Whether the map is known well enough: eq. (9).
    pub(super) fn is_converged(&self, snapshot: &Snapshot) -> Result<bool, Cancelled> {
        let Some(q_thresh) = self.config.stop.entropy_share.filter(|_| self.scene.map.is_finest()) else {
            return Ok(false);
        };
        Ok(snapshot.entropy_share_unless(&self.cancel)? < q_thresh)
    }

    /// Returns the reason not to follow this plan, if any. Without a choice, it is followed by one in finer
    /// voxels, if there are any.
    pub(super) fn stops_after(&self, plan: &Plan) -> Option<StopReason> {
        let StopConfig { completeness, path_length, .. } = self.config.stop;
        let is_finest = self.scene.map.is_finest();
        let outlook = plan.outlook.as_ref().filter(|_| is_finest);
        if outlook.zip(completeness).is_some_and(|(outlook, enough)| outlook.completeness() >= enough) {
            return Some(StopReason::Complete);
        }
        let Some(choice) = &plan.choice else { return is_finest.then(|| self.reason_for_no_choice()) };
        let share_at_goal = self.scene.quality.as_ref().map(goal::MeasuredQuality::share_at_goal);
        let little = self.config.stop.little_gain(share_at_goal);
        if outlook.is_some_and(|outlook| outlook.gain() < little) {
            return Some(StopReason::LittleToGain);
        }
        let is_too_long = path_length.is_some_and(|limit| self.path_length_with(choice.view) > limit);
        is_too_long.then_some(StopReason::PathLimit)
    }

    /// Whether the last views together hardly showed or improved anything.
    fn has_stalled(&self) -> bool {
        let n = StopConfig::PROGRESS_VIEWS;
        let is_little = |share: f64| share < self.config.stop.progress;
        let quality = self.scene.quality.as_ref();
        self.scene.seen.progress(n).is_some_and(is_little)
            && quality.and_then(|quality| quality.progress(n)).is_none_or(is_little)
    }

    /// Returns the reason why no view was chosen: none is within reach, or none gains anything.
    fn reason_for_no_choice(&self) -> StopReason {
        let is_open = |(view, time): (usize, &Option<f64>)| time.is_some() && !self.visited.contains(&view);
        match &self.approaches {
            Some(times) if !times.iter().enumerate().any(is_open) => StopReason::OutOfReach,
            _ => StopReason::NothingToGain,
        }
    }

    /// Returns the length of the straight path through all camera positions and on to a view, metres.
    fn path_length_with(&self, view: usize) -> f64 {
        let next = self.candidates.pose(view).translation();
        let last = self.scene.frames.places.last().map(|last| last.translation().distance(next));
        self.legs().sum::<f64>() + last.unwrap_or(0.0)
    }
}
