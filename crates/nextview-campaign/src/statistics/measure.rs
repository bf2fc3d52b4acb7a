//! The numbers of a run: the list of measures for tables, figures and comparisons.

use super::{MeasuredRun, mean, percentile};
use std::cmp::Ordering;

/// Shown in place of a missing number.
const DASH: &str = "–";

/// A number of a run, or a mean over runs.
#[derive(Clone, Copy, Debug)]
pub struct Measure {
    /// Name with the displayed unit.
    pub name: &'static str,
    /// Displayed units per unit of the run.
    pub factor: f64,
    /// Number of displayed decimals.
    pub decimals: usize,
    /// The better direction.
    pub better: Better,
    /// The number of a run; `None` if the run did not measure it.
    pub of: fn(&MeasuredRun) -> Option<f64>,
}

/// The better direction of a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Better {
    /// Large values are better.
    Higher,
    /// Small values are better.
    Lower,
}

impl Better {
    /// Orders values from worse to better.
    pub fn order(self, a: f64, b: f64) -> Ordering {
        match self {
            Self::Higher => a.total_cmp(&b),
            Self::Lower => b.total_cmp(&a),
        }
    }
}

impl Measure {
    /// Formats the number in the displayed unit, without the unit; a dash if it is too large for a number.
    pub fn show(&self, value: f64) -> String {
        let shown = self.factor * value;
        // Plus zero turns a negative zero into zero.
        if shown.is_finite() { format!("{:.*}", self.decimals, shown + 0.0) } else { DASH.to_owned() }
    }

    /// Formats a difference, with its sign and one more decimal.
    pub fn show_difference(&self, value: f64) -> String {
        let shown = self.factor * value;
        match shown.is_finite() {
            true => format!("{:+.*}", self.decimals + 1, shown + 0.0).replace('-', "−"),
            false => DASH.to_owned(),
        }
    }

    /// Returns the unit of a difference: points for a percentage, otherwise that of the measure, which is
    /// part of its name.
    pub fn difference_unit(&self) -> Option<&'static str> {
        self.name.ends_with(", %").then_some("points")
    }
}

/// Occupied object voxels over object voxels, after the last view.
pub const VOXEL_COVERAGE: Measure = Measure {
    name: "voxel coverage, %",
    factor: 100.0,
    decimals: 1,
    better: Better::Higher,
    of: |run| run.last_step()?.voxel_coverage,
};

/// Share of the reachable surface seen after the last view.
pub const REACHABLE_COVERAGE: Measure = Measure {
    name: "reachable coverage, %",
    factor: 100.0,
    decimals: 1,
    better: Better::Higher,
    of: |run| run.last_step()?.reachable_coverage,
};

/// Reachable coverage beyond the mean of random views from the same start.
pub const COVERAGE_BEYOND_RANDOM: Measure = Measure {
    name: "beyond random views, points",
    of: |run| Some((REACHABLE_COVERAGE.of)(run)? - *run.random_curve.as_ref()?.last()?),
    ..REACHABLE_COVERAGE
};

/// Area under the curve of reachable coverage on the scale from random views (0) to the clairvoyant planner
/// (1).
pub const SKILL: Measure =
    Measure { name: "skill", factor: 1.0, decimals: 2, better: Better::Higher, of: |run| run.whole.skill };

/// Share of the true surface with a measured point within 2 mm.
pub const SURFACE_2MM: Measure = Measure {
    name: "surface coverage within 2 mm, %",
    factor: 100.0,
    decimals: 1,
    better: Better::Higher,
    of: |run| run.last.surface_coverage_2mm,
};

/// Share of the true surface with a measured point within 5 mm.
pub const SURFACE_5MM: Measure = Measure {
    name: "surface coverage within 5 mm, %",
    of: |run| run.last.surface_coverage_5mm,
    ..SURFACE_2MM
};

/// Mean distance from the points of the final cloud to the true surface.
pub const ACCURACY: Measure = Measure {
    name: "accuracy of the cloud, mm",
    factor: 1.0,
    decimals: 2,
    better: Better::Lower,
    of: |run| run.whole.cloud_accuracy_mean_mm,
};

/// Share of the true surface with a point of the final cloud within 2 mm.
pub const COMPLETENESS: Measure = Measure {
    name: "completeness of the cloud within 2 mm, %",
    of: |run| run.whole.cloud_completeness_2mm,
    ..SURFACE_2MM
};

/// Share of the occupied voxels that are object voxels, after the last view.
pub const MAP_PRECISION: Measure =
    Measure { name: "precision of the map, %", of: |run| run.last.map_precision, ..SURFACE_2MM };

/// Share of the reachable object voxels that are occupied, after the last view.
pub const MAP_RECALL: Measure =
    Measure { name: "recall of the map, %", of: |run| run.last.map_recall, ..SURFACE_2MM };

/// Intersection over union of the occupied and the reachable object voxels, after the last view.
pub const MAP_IOU: Measure = Measure { name: "IoU of the map, %", of: |run| run.last.map_iou, ..SURFACE_2MM };

/// Harmonic mean of precision and recall of the final cloud at 1 mm.
pub const F_SCORE_1MM: Measure =
    Measure { name: "F-score of the cloud at 1 mm, %", of: |run| run.whole.cloud_f_score_1mm, ..SURFACE_2MM };

/// Harmonic mean of precision and recall of the final cloud at 2 mm.
pub const F_SCORE_2MM: Measure =
    Measure { name: "F-score of the cloud at 2 mm, %", of: |run| run.whole.cloud_f_score_2mm, ..SURFACE_2MM };

/// Harmonic mean of precision and recall of the final cloud at 5 mm.
pub const F_SCORE_5MM: Measure =
    Measure { name: "F-score of the cloud at 5 mm, %", of: |run| run.whole.cloud_f_score_5mm, ..SURFACE_2MM };

/// Mean of accuracy and completeness of the final cloud against the reachable surface.
pub const CHAMFER: Measure =
    Measure { name: "Chamfer distance of the cloud, mm", of: |run| run.whole.cloud_chamfer_mm, ..ACCURACY };

/// Mean of the reachable coverage over the maximum number of views.
pub const AREA_OVER_VIEWS: Measure = Measure {
    name: "area under coverage over views, %",
    of: |run| run.whole.coverage_auc_views,
    ..SURFACE_2MM
};

/// Mean of the reachable coverage over a robot's time.
pub const AREA_OVER_TIME: Measure = Measure {
    name: "area under coverage over time, %",
    of: |run| run.whole.coverage_auc_time,
    ..SURFACE_2MM
};

/// Number of views until 95 % of the reachable surface was seen; one more than the maximum number of views if
/// it was not.
pub const VIEWS_TO_95: Measure = Measure {
    name: "views to 95 %",
    factor: 1.0,
    decimals: 1,
    better: Better::Lower,
    of: |run| run.views_to(0.95),
};

/// Length of the straight path through the positions of all views.
pub const PATH: Measure = Measure {
    name: "path length, m",
    factor: 1.0,
    decimals: 2,
    better: Better::Lower,
    of: |run| Some(run.last.path_length_m),
};

/// Median planning time over the views of a run.
pub const PLAN_TIME: Measure = Measure {
    name: "planning time per view, ms",
    factor: 1.0,
    decimals: 1,
    better: Better::Lower,
    of: |run| percentile(&run.plan_times().collect::<Vec<_>>(), 0.5),
};

/// Mean planning time, as in the paper's tables.
pub const COMPUTING_TIME: Measure = Measure {
    name: "computing time per view, s",
    factor: 1e-3,
    decimals: 3,
    better: Better::Lower,
    of: |run| mean(&run.plan_times().collect::<Vec<_>>()),
};

/// Growth of the process's peak memory in a run.
pub const MEMORY: Measure = Measure {
    name: "extra memory, MB",
    factor: 1.0,
    decimals: 1,
    better: Better::Lower,
    of: |run| run.whole.extra_memory_mb,
};

/// Time to plan all views and to integrate all frames into the map.
pub const PLANNING: Measure = Measure {
    name: "planning, s",
    factor: 1.0,
    decimals: 2,
    better: Better::Lower,
    of: |run| Some(run.planning_time()),
};

/// Time for a simulated robot to move to all views.
pub const MOVING: Measure =
    Measure { name: "moving, s", decimals: 1, of: |run| Some(run.moving_time()), ..PLANNING };

/// Time that the robot stands at views.
pub const SENSING: Measure =
    Measure { name: "sensing, s", decimals: 1, of: |run| Some(run.sensing_time()), ..PLANNING };

/// The sum of planning, moving and sensing.
pub const RUNNING_TIME: Measure = Measure {
    name: "total, minutes",
    factor: 1.0 / 60.0,
    of: |run| Some(run.planning_time() + run.moving_time() + run.sensing_time()),
    ..PLANNING
};
