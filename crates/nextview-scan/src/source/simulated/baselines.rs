use super::SimulatedObject;
use crate::{Fault, ScanConfig, ScanRecord};
use nextview::Cancel;
use nextview::geometry::Pose;
use nextview_sim::baseline::{RandomCurve, clairvoyant_curve, extended, skill};
use nextview_sim::truth::TrueVisibility;
use rayon::prelude::*;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// The truth of an object and its candidates: what every candidate truly sees.
#[derive(Debug)]
pub struct Truth {
    /// By candidate.
    pub visibility: Arc<TrueVisibility>,
    /// Time it took to look.
    pub time: Duration,
}

impl Truth {
    /// Looks from every candidate. `progress` is called after every view, from several threads.
    ///
    /// Fails if it is cancelled.
    pub fn new(object: &SimulatedObject, cancel: &Cancel, progress: impl Fn() + Sync) -> Result<Self, Fault> {
        let start = Instant::now();
        let camera = object.scene.camera();
        let look = |pose: &Pose| {
            cancel.check()?;
            let seen = object.object_voxels.seen_from(camera, pose).map_err(Fault::from)?;
            progress();
            Ok(seen)
        };
        let seen = object.views.poses().par_iter().map(look).collect::<Result<Vec<_>, Fault>>()?;
        let visibility = TrueVisibility::of_seen(seen).ok_or_else(|| {
            Fault::data("no view candidate sees the object: is it beyond the camera's range, or are the views elsewhere?")
        })?;
        Ok(Self::of(visibility, start.elapsed()))
    }

    /// The truth that was found in this time.
    pub(in crate::source) fn of(visibility: TrueVisibility, time: Duration) -> Self {
        Self { visibility: Arc::new(visibility), time }
    }
}

/// The coverage of random views and of the planner that knows the object, which every planner is measured
/// against.
#[derive(Debug)]
pub struct Baselines {
    truth: Arc<TrueVisibility>,
    random: RandomCurve,
    clairvoyant: Vec<f64>,
    /// Time they took, apart from the scan.
    time: Duration,
}

impl Baselines {
    /// The curves from the configured first view over the configured number of views.
    pub fn new(truth: &Truth, config: &ScanConfig) -> Self {
        let start = Instant::now();
        let visibility = truth.visibility.clone();
        let n_views = config.max_views(visibility.n_views());
        Self {
            random: RandomCurve::new(&visibility, config.first_view, n_views),
            clairvoyant: clairvoyant_curve(&visibility, config.first_view, n_views),
            truth: visibility,
            time: truth.time + start.elapsed(),
        }
    }

    /// Share, 0..=1, of the reachable object voxels that so many seen ones are.
    pub(crate) fn reachable_coverage(&self, n_seen: usize) -> f64 {
        n_seen as f64 / self.truth.n_reachable() as f64
    }

    /// Fills in the curves and the skill.
    pub(crate) fn describe(&self, record: &mut ScanRecord) {
        let curve = record.reachable_coverage_curve();
        record.reachable_voxels = Some(self.truth.n_reachable());
        record.reachable_coverage = curve.as_ref().and_then(|curve| curve.last().copied());
        let extended = curve.map(|curve| extended(curve, self.random.mean.len()));
        record.skill = extended.and_then(|curve| skill(&curve, &self.random.mean, &self.clairvoyant));
        record.random_curve = Some(self.random.mean.clone());
        record.random_low_curve = Some(self.random.low.clone());
        record.random_high_curve = Some(self.random.high.clone());
        record.clairvoyant_curve = Some(self.clairvoyant.clone());
        record.baseline_time_ms = Some(crate::record::milliseconds(self.time));
    }
}
