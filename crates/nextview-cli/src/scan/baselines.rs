use super::ScanConfig;
use crate::Failure;
use nextview::view::ViewSpace;
use nextview_sim::baseline::{RandomCurve, clairvoyant_curve};
use nextview_sim::scene::Scene;
use nextview_sim::truth::{ObjectVoxels, TrueVisibility};
use std::sync::Arc;
use std::time::{Duration, Instant};

/// What every planner is measured against.
#[derive(Debug)]
pub(super) struct Baselines {
    pub truth: Arc<TrueVisibility>,
    pub random: RandomCurve,
    pub clairvoyant: Vec<f64>,
    /// Time they took, apart from the scan.
    pub time: Duration,
}

impl Baselines {
    pub fn new(
        scene: &Scene,
        object: &ObjectVoxels,
        views: &ViewSpace,
        config: &ScanConfig,
        progress: impl Fn() + Sync,
    ) -> Result<Self, Failure> {
        let start = Instant::now();
        let truth = Arc::new(TrueVisibility::new(scene.camera(), object, views, progress)?);
        Ok(Self {
            random: RandomCurve::new(&truth, config.first_view, config.views),
            clairvoyant: clairvoyant_curve(&truth, config.first_view, config.views),
            truth,
            time: start.elapsed(),
        })
    }
}
