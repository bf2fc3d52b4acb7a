use crate::RunRecord;
use nextview_scan::{ScanConfig, ScanRecord, StepRecord};

/// A run that took at least one view and did not fail.
#[derive(Clone, Copy, Debug)]
pub struct MeasuredRun<'a> {
    /// What it was drawn by: seed, set of candidates and first view.
    pub draw: (u64, u64, usize),
    /// Everything that decided it.
    pub config: &'a ScanConfig,
    /// What was measured.
    pub record: &'a ScanRecord,
    /// Growth of the process's peak memory in the run; none where it was not alone.
    pub extra_memory_mb: Option<f64>,
}

/// A quantity over the number of views.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Curve {
    /// Occupied object voxels over object voxels.
    VoxelCoverage,
    /// Share of the reachable surface seen.
    ReachableCoverage,
    /// Entropy of the box as a share of that of an unknown one.
    Entropy,
}

impl<'a> MeasuredRun<'a> {
    /// The run of a record; none if it failed or took no view.
    pub fn of(run: &'a RunRecord) -> Option<Self> {
        let done = run.done().filter(|done| !done.record.steps.is_empty())?;
        Some(Self {
            draw: (run.seed, run.view_seed, run.first_view),
            config: &run.config,
            record: &done.record,
            extra_memory_mb: done.extra_memory_mb,
        })
    }

    /// The quantity after each view; after a scan that stopped early, the last value stays. None where the
    /// run did not measure it.
    pub fn curve(&self, of: Curve) -> Option<Vec<f64>> {
        let values = self.record.steps.iter().map(|step| match of {
            Curve::VoxelCoverage => step.voxel_coverage,
            Curve::ReachableCoverage => step.reachable_coverage,
            Curve::Entropy => Some(step.entropy_share),
        });
        let mut values = values.collect::<Option<Vec<f64>>>()?;
        let last = *values.last()?;
        values.resize(self.config.views.unwrap_or_default().max(values.len()), last);
        Some(values)
    }

    /// Views until this share of the reachable surface was seen; one more than the run could take where it
    /// was not.
    pub fn views_to(&self, share: f64) -> Option<f64> {
        let curve = self.curve(Curve::ReachableCoverage)?;
        Some((curve.iter().position(|&coverage| coverage >= share).unwrap_or(curve.len()) + 1) as f64)
    }

    /// Whether this share of the reachable surface was seen.
    pub fn reaches(&self, share: f64) -> bool {
        self.record.steps.iter().any(|step| step.reachable_coverage.is_some_and(|coverage| coverage >= share))
    }

    /// Milliseconds for each view that was planned; the first is given.
    pub fn plan_times(&self) -> impl Iterator<Item = f64> + use<'a> {
        self.record.steps.iter().skip(1).map(|step| step.plan_time_ms)
    }

    /// The step of the last view.
    pub(super) fn last(&self) -> Option<&'a StepRecord> {
        self.record.steps.last()
    }

    /// Seconds for all decisions and for writing the frames into the map.
    pub(super) fn planning_time(&self) -> f64 {
        let mapping = self.record.steps.iter().map(|step| step.map_time_ms);
        self.plan_times().chain(mapping).sum::<f64>() / 1e3
    }

    /// Seconds that a simulated robot moves.
    pub(super) fn moving_time(&self) -> Option<f64> {
        Some(self.last()?.trajectory_time_s)
    }

    /// Seconds that it stands at views.
    pub(super) fn sensing_time(&self) -> f64 {
        self.config.motion.sensing_time * self.record.steps.len() as f64
    }
}
