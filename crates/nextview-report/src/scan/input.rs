use super::picture::ViewPicture;
use super::shown::ShownModel;
use glam::{DVec3, Vec3};
use nextview::session::NextView;
use nextview_scan::{ScanConfig, ScanRecord, StepRecord};

/// A scan to show, finished or in progress. All strings are plain text; the page escapes them.
#[derive(Clone, Copy, Debug)]
pub struct ScanPage<'a> {
    /// The scan. Without a `stop_reason`, it is shown as in progress.
    pub record: &'a ScanRecord,
    /// The scan's configuration.
    pub config: &'a ScanConfig,
    /// Pictures of the record's steps, in the same order. A step without one shows only its numbers.
    pub views: &'a [ViewPicture],
    /// Positions of the view candidates, world frame, metres.
    pub candidates: &'a [DVec3],
    /// The measured and expected surface, and the gains of these candidates.
    pub model: &'a ShownModel,
    /// The next view; `None` if nothing is proposed.
    pub next: Option<&'a NextView>,
    /// The command that repeats this scan.
    pub command: &'a str,
    /// The resolved configuration as text.
    pub config_text: &'a str,
}

impl<'a> ScanPage<'a> {
    /// The views, in order of capture.
    pub(super) fn steps(&self) -> &'a [StepRecord] {
        &self.record.steps
    }

    /// The picture of the step with this index; `None` if it has none.
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

    /// Length of the straight path to the step with this index from the previous one, metres.
    pub(super) fn travel(&self, step_idx: usize) -> f64 {
        let before = step_idx.checked_sub(1).map_or(0.0, |before| self.steps()[before].path_length_m);
        self.steps()[step_idx].path_length_m - before
    }
}
