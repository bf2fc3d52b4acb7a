use super::picture::ViewPicture;
use super::shown::ShownModel;
use glam::{DVec3, Vec3};
use nextview::session::NextView;
use nextview_scan::{ScanConfig, ScanRecord, StepRecord};

/// A scan to show, finished or under way. All strings are plain text; the page escapes them.
#[derive(Clone, Copy, Debug)]
pub struct ScanPage<'a> {
    /// The scan. Without a `stop_reason`, it is shown as under way.
    pub record: &'a ScanRecord,
    /// Its configuration.
    pub config: &'a ScanConfig,
    /// A picture of each step of the record, in the same order. For a step without one, only the numbers are
    /// shown.
    pub views: &'a [ViewPicture],
    /// Positions of the view candidates, world frame, metres.
    pub candidates: &'a [DVec3],
    /// The surface, measured and expected, and the gains of these candidates.
    pub model: &'a ShownModel,
    /// The view to take next; none where nothing is proposed.
    pub next: Option<&'a NextView>,
    /// The command that runs this scan again.
    pub command: &'a str,
    /// The resolved configuration as text.
    pub config_text: &'a str,
}

impl<'a> ScanPage<'a> {
    /// The views, in the order in which they were taken.
    pub(super) fn steps(&self) -> &'a [StepRecord] {
        &self.record.steps
    }

    /// The picture of the step with this index; none without one.
    pub(super) fn picture(&self, step_idx: usize) -> Option<&'a ViewPicture> {
        self.views.get(step_idx)
    }

    /// The points of the step with this index.
    pub(super) fn points(&self, step_idx: usize) -> &'a [Vec3] {
        self.picture(step_idx).map_or(&[], |picture| &picture.points)
    }

    /// The number of points of all steps.
    pub(super) fn n_points(&self) -> usize {
        (0..self.steps().len()).map(|i| self.points(i).len()).sum()
    }

    /// Length of the straight path to the step with this index from the one before, metres.
    pub(super) fn travel(&self, step_idx: usize) -> f64 {
        let before = step_idx.checked_sub(1).map_or(0.0, |before| self.steps()[before].path_length_m);
        self.steps()[step_idx].path_length_m - before
    }
}
