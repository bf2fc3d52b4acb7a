use crate::{DoneRun, RunRecord};
use nextview_scan::{ScanConfig, ScanRecord, StepRecord};

/// A run that took at least one view and did not fail: its numbers for statistics, about a tenth of its
/// record.
#[derive(Clone, Debug, PartialEq)]
pub struct MeasuredRun {
    /// The draws of the run: seed, set of candidates and first view.
    pub draw: (u64, u64, usize),
    /// After each view.
    pub steps: Vec<MeasuredStep>,
    /// Number of object voxels that any candidate sees.
    pub reachable_voxels: Option<usize>,
    /// Number of voxels that contain true surface.
    pub object_voxels: Option<usize>,
    /// Mean reachable coverage of random views from the same start.
    pub random_curve: Option<Vec<f64>>,
    /// Reachable coverage of the clairvoyant planner from the same start.
    pub clairvoyant_curve: Option<Vec<f64>>,
    /// Measures of the last view.
    pub(super) last: LastView,
    /// Measures of the whole scan.
    pub(super) whole: WholeScan,
    /// Maximum number of views.
    max_views: usize,
    /// Time that a robot spends standing at a view, in seconds.
    sensing_time: f64,
}

/// The numbers of a view for statistics.
#[derive(Clone, Debug, PartialEq)]
pub struct MeasuredStep {
    /// Occupied object voxels over object voxels.
    pub voxel_coverage: Option<f64>,
    /// Share of the reachable surface seen.
    pub reachable_coverage: Option<f64>,
    /// Entropy of the box as a share of that of an unknown box.
    pub entropy_share: f64,
    /// The planner's estimate of the reachable coverage before it took the view.
    pub estimated_completeness: Option<f64>,
    /// The planner's forecast of the reachable coverage after this view and after each of the next few.
    pub forecast_completeness: Option<Vec<f64>>,
    plan_time_ms: f64,
    map_time_ms: f64,
}

/// Measures of the last view.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct LastView {
    pub surface_coverage_2mm: Option<f64>,
    pub surface_coverage_5mm: Option<f64>,
    pub map_precision: Option<f64>,
    pub map_recall: Option<f64>,
    pub map_iou: Option<f64>,
    pub path_length_m: f64,
    trajectory_time_s: f64,
}

/// Measures of the whole scan.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct WholeScan {
    pub skill: Option<f64>,
    pub coverage_auc_views: Option<f64>,
    pub coverage_auc_time: Option<f64>,
    pub cloud_accuracy_mean_mm: Option<f64>,
    pub cloud_completeness_2mm: Option<f64>,
    pub cloud_f_score_1mm: Option<f64>,
    pub cloud_f_score_2mm: Option<f64>,
    pub cloud_f_score_5mm: Option<f64>,
    pub cloud_chamfer_mm: Option<f64>,
    pub extra_memory_mb: Option<f64>,
}

/// A quantity over the number of views.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Curve {
    /// Occupied object voxels over object voxels.
    VoxelCoverage,
    /// Share of the reachable surface seen.
    ReachableCoverage,
    /// Entropy of the box as a share of that of an unknown box.
    Entropy,
}

impl MeasuredRun {
    /// Measures the run of a record; `None` if it failed or took no view.
    pub fn of(run: &RunRecord) -> Option<Self> {
        let DoneRun { record, extra_memory_mb } = run.done()?;
        let ScanConfig { views, motion, .. } = &run.config;
        Some(Self {
            draw: (run.seed, run.view_seed, run.first_view),
            steps: record.steps.iter().map(MeasuredStep::of).collect(),
            reachable_voxels: record.reachable_voxels,
            object_voxels: record.object_voxels,
            random_curve: record.random_curve.clone(),
            clairvoyant_curve: record.clairvoyant_curve.clone(),
            last: LastView::of(record.steps.last()?),
            whole: WholeScan::of(record, *extra_memory_mb),
            max_views: views.unwrap_or_default(),
            sensing_time: motion.sensing_time,
        })
    }

    /// Returns the quantity after each view; the last value continues after a scan that stopped early. `None`
    /// if the run did not measure it.
    pub fn curve(&self, of: Curve) -> Option<Vec<f64>> {
        let values = self.steps.iter().map(|step| match of {
            Curve::VoxelCoverage => step.voxel_coverage,
            Curve::ReachableCoverage => step.reachable_coverage,
            Curve::Entropy => Some(step.entropy_share),
        });
        let mut values = values.collect::<Option<Vec<f64>>>()?;
        let last = *values.last()?;
        values.resize(self.max_views.max(values.len()), last);
        Some(values)
    }

    /// Returns the number of views until this share of the reachable surface was seen; one more than the
    /// maximum number of views if it was not.
    pub fn views_to(&self, share: f64) -> Option<f64> {
        let curve = self.curve(Curve::ReachableCoverage)?;
        Some((curve.iter().position(|&coverage| coverage >= share).unwrap_or(curve.len()) + 1) as f64)
    }

    /// Returns whether this share of the reachable surface was seen.
    pub fn reaches(&self, share: f64) -> bool {
        self.steps.iter().any(|step| step.reachable_coverage.is_some_and(|coverage| coverage >= share))
    }

    /// Returns the time to plan each view, in milliseconds, without the first view, which is given.
    pub fn plan_times(&self) -> impl Iterator<Item = f64> {
        self.steps.iter().skip(1).map(|step| step.plan_time_ms)
    }

    /// The step of the last view.
    pub(super) fn last_step(&self) -> Option<&MeasuredStep> {
        self.steps.last()
    }

    /// Time for all decisions and for the integration of the frames into the map, in seconds.
    pub(super) fn planning_time(&self) -> f64 {
        let mapping = self.steps.iter().map(|step| step.map_time_ms);
        self.plan_times().chain(mapping).sum::<f64>() / 1e3
    }

    /// Time that a simulated robot spends moving, in seconds.
    pub(super) fn moving_time(&self) -> f64 {
        self.last.trajectory_time_s
    }

    /// Time that the robot spends standing at views, in seconds.
    pub(super) fn sensing_time(&self) -> f64 {
        self.sensing_time * self.steps.len() as f64
    }
}

impl MeasuredStep {
    fn of(step: &StepRecord) -> Self {
        Self {
            voxel_coverage: step.voxel_coverage,
            reachable_coverage: step.reachable_coverage,
            entropy_share: step.entropy_share,
            estimated_completeness: step.estimated_completeness,
            forecast_completeness: step.forecast_completeness.clone(),
            plan_time_ms: step.plan_time_ms,
            map_time_ms: step.map_time_ms,
        }
    }
}

impl LastView {
    fn of(step: &StepRecord) -> Self {
        Self {
            surface_coverage_2mm: step.surface_coverage_2mm,
            surface_coverage_5mm: step.surface_coverage_5mm,
            map_precision: step.map_precision,
            map_recall: step.map_recall,
            map_iou: step.map_iou,
            path_length_m: step.path_length_m,
            trajectory_time_s: step.trajectory_time_s,
        }
    }
}

impl WholeScan {
    fn of(record: &ScanRecord, extra_memory_mb: Option<f64>) -> Self {
        Self {
            skill: record.skill,
            coverage_auc_views: record.coverage_auc_views,
            coverage_auc_time: record.coverage_auc_time,
            cloud_accuracy_mean_mm: record.cloud_accuracy_mean_mm,
            cloud_completeness_2mm: record.cloud_completeness_2mm,
            cloud_f_score_1mm: record.cloud_f_score_1mm,
            cloud_f_score_2mm: record.cloud_f_score_2mm,
            cloud_f_score_5mm: record.cloud_f_score_5mm,
            cloud_chamfer_mm: record.cloud_chamfer_mm,
            extra_memory_mb,
        }
    }
}
