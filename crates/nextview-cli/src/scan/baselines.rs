use super::{ScanConfig, Setting};
use crate::Failure;
use nextview_sim::baseline::{RandomCurve, clairvoyant_curve, extended, skill};
use nextview_sim::gauge::Measures;
use nextview_sim::truth::TrueVisibility;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// What every candidate of a setting truly sees.
#[derive(Debug)]
pub(crate) struct Truth {
    pub visibility: Arc<TrueVisibility>,
    /// Time it took to look.
    pub time: Duration,
}

impl Truth {
    /// Looks from every candidate. `progress` is told of every finished view, from several threads.
    pub fn new(setting: &Setting, progress: impl Fn() + Sync) -> Result<Self, Failure> {
        let start = Instant::now();
        let camera = setting.scene.camera();
        let visibility = TrueVisibility::new(camera, &setting.object_voxels, &setting.views, progress)?;
        Ok(Self { visibility: Arc::new(visibility), time: start.elapsed() })
    }
}

/// What every planner is measured against.
#[derive(Debug)]
pub(crate) struct Baselines {
    truth: Arc<TrueVisibility>,
    pub random: RandomCurve,
    pub clairvoyant: Vec<f64>,
    /// Time they took, apart from the scan.
    pub time: Duration,
}

impl Baselines {
    /// The curves from the configured first view over the configured number of views.
    pub fn new(truth: &Truth, config: &ScanConfig) -> Self {
        let start = Instant::now();
        let visibility = truth.visibility.clone();
        Self {
            random: RandomCurve::new(&visibility, config.first_view, config.views),
            clairvoyant: clairvoyant_curve(&visibility, config.first_view, config.views),
            truth: visibility,
            time: truth.time + start.elapsed(),
        }
    }

    /// Number of object voxels that any candidate sees.
    pub fn n_reachable(&self) -> usize {
        self.truth.n_reachable()
    }

    /// Share of the reachable object voxels seen up to a step.
    pub fn reachable_coverage(&self, measures: &Measures) -> f64 {
        measures.n_seen as f64 / self.n_reachable() as f64
    }

    /// Area under the curve of the steps from random (0) to clairvoyant (1).
    pub fn skill<'a>(&self, steps: impl Iterator<Item = &'a Measures>) -> Option<f64> {
        let curve = steps.map(|measures| self.reachable_coverage(measures)).collect();
        skill(&extended(curve, self.random.mean.len()), &self.random.mean, &self.clairvoyant)
    }
}
