use crate::Error;
use crate::checked::{check_range, checked_when_read};
use serde::{Deserialize, Serialize};

/// Conditions that end a scan before the maximum number of views. By default, it ends when no view gains
/// anything, when the last six together gained little, or when each of the next is expected to gain little.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields, remote = "Self")]
pub struct StopConfig {
    /// Stop when the entropy in the box is below this share, 0..=1, of that of an unknown box: q_thresh of
    /// the paper's eq. (9), which uses 0.5. Default: off, because the share measures how empty the box is
    /// rather than how completely the object was seen.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub entropy_share: Option<f64>,
    /// Stop when this share, 0..=1, of the visible surface is
    /// [estimated](crate::planner::Outlook::completeness) to have been seen. Default: off. It has no effect
    /// on planners without expectations.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub completeness: Option<f64>,
    /// Stop when each of the next views is expected to add less than this share, 0..=1, to the surface seen
    /// so far. Default: a tenth of `progress`, because six views that each add so little would be no progress
    /// either; 0, which is off, while more than `progress` of the surface does not reach the goals for error
    /// or number of looks. It has no effect on planners without expectations.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub expected_gain: Option<f64>,
    /// Stop when the last [six frames](Self::PROGRESS_VIEWS) together added less than this share, 0..=1, to
    /// the measured surface, in cells of two voxels. Default 0.01; 0 is off.
    pub progress: f64,
    /// Stop before the straight path through all views becomes longer than this, metres, positive. Default:
    /// off.
    #[serde(rename = "path_length_m", skip_serializing_if = "Option::is_none")]
    pub path_length: Option<f64>,
}

checked_when_read!(StopConfig);

impl Default for StopConfig {
    fn default() -> Self {
        Self {
            entropy_share: None,
            completeness: None,
            expected_gain: None,
            progress: 0.01,
            path_length: None,
        }
    }
}

impl StopConfig {
    /// Returns the share of the seen surface below which an expected gain ends a scan. `share_at_goal` is the
    /// share of the measured surface that reaches the goals, if there are any.
    pub(super) fn little_gain(&self, share_at_goal: Option<f64>) -> f64 {
        let is_at_goal = share_at_goal.is_none_or(|share| share >= 1.0 - self.progress);
        let default = if is_at_goal { 0.1 * self.progress } else { 0.0 };
        self.expected_gain.unwrap_or(default)
    }

    /// Number of views over which [`progress`](Self::progress) is measured: when the object is nearly
    /// complete, two or three in a row may be unlucky.
    pub const PROGRESS_VIEWS: usize = 6;

    /// Fails on the first value out of range.
    pub fn check(&self) -> Result<(), Error> {
        let shares = [
            ("entropy_share", self.entropy_share),
            ("completeness", self.completeness),
            ("expected_gain", self.expected_gain),
        ];
        for (name, share) in shares.into_iter().filter_map(|(name, share)| Some((name, share?))) {
            check_range(name, share, 0.0..=1.0, "a number in 0..=1")?;
        }
        check_range("progress", self.progress, 0.0..=1.0, "a number in 0..=1")?;
        let positive = f64::MIN_POSITIVE..=f64::INFINITY;
        self.path_length.map_or(Ok(()), |length| {
            check_range("path_length_m", length, positive, "a positive number of metres")
        })
    }
}
