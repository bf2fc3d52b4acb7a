use super::SimulatedObject;
use crate::{Fault, ScanConfig, ScanRecord, StepRecord};
use fixedbitset::FixedBitSet;
use nextview::Cancel;
use nextview::geometry::Pose;
use nextview_sim::area;
use nextview_sim::baseline::{RandomCurve, clairvoyant_curve, extended, skill};
use nextview_sim::quality::ReachableSurface;
use nextview_sim::truth::TrueVisibility;
use rayon::prelude::*;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Travel time of a robot to a view in seconds, for the horizon of the area over time: about the mean for
/// random views of an object of 0.2 m.
const MOVING_TIME: f64 = 4.0;

/// Ground truth about an object and its candidates: the surface visible from each candidate.
#[derive(Debug)]
pub struct Truth {
    /// For each candidate: object voxels or, for a recording, surface samples.
    pub visibility: Arc<TrueVisibility>,
    /// The object voxels in which any candidate measures a point of the object.
    pub reachable_voxels: FixedBitSet,
    /// The part of the true surface visible from any candidate.
    pub reachable_surface: ReachableSurface,
    /// Time taken to compute it.
    pub time: Duration,
}

impl Truth {
    /// Renders the view of every candidate. `progress` is called after every view, from several threads.
    ///
    /// Fails if cancelled.
    pub fn new(object: &SimulatedObject, cancel: &Cancel, progress: impl Fn() + Sync) -> Result<Self, Fault> {
        let start = Instant::now();
        let samples = object.true_surface.samples();
        let reachable_surface = ReachableSurface::new(samples.len());
        let look = |pose: &Pose| {
            cancel.check()?;
            let look = object.scene.camera().look(pose).map_err(Fault::from)?;
            reachable_surface.add(samples, &look);
            progress();
            Ok(object.object_voxels.seen_by(&look))
        };
        let seen = object.views.poses().par_iter().map(look).collect::<Result<Vec<_>, Fault>>()?;
        let visibility = TrueVisibility::of_seen(seen).ok_or_else(|| {
            Fault::data("no view candidate sees the object: is it beyond the camera's range, or are the views elsewhere?")
        })?;
        let reachable_voxels = visibility.reachable().clone();
        let visibility = Arc::new(visibility);
        Ok(Self { visibility, reachable_voxels, reachable_surface, time: start.elapsed() })
    }
}

/// The coverage of random views and of the planner that knows the object: the scale for every planner.
#[derive(Debug)]
pub struct Baselines {
    truth: Arc<TrueVisibility>,
    random: RandomCurve,
    clairvoyant: Vec<f64>,
    /// Sensing time of a robot at a view in seconds.
    sensing_time: f64,
    /// Time taken to compute them, excluded from the scan.
    time: Duration,
}

impl Baselines {
    /// Computes the curves from the configured first view over the configured number of views.
    pub fn new(truth: &Truth, config: &ScanConfig) -> Self {
        let start = Instant::now();
        let visibility = truth.visibility.clone();
        let n_views = config.max_views(visibility.n_views());
        Self {
            random: RandomCurve::new(&visibility, config.first_view, n_views, config.baseline_seed),
            clairvoyant: clairvoyant_curve(&visibility, config.first_view, n_views),
            sensing_time: config.motion.sensing_time,
            truth: visibility,
            time: truth.time + start.elapsed(),
        }
    }

    /// Converts a number of seen object voxels to a share, 0..=1, of the reachable ones.
    pub(crate) fn reachable_coverage(&self, n_seen: usize) -> f64 {
        n_seen as f64 / self.truth.n_reachable() as f64
    }

    /// Fills in the curves, the skill and the areas under the curve.
    pub(crate) fn describe(&self, record: &mut ScanRecord) {
        let curve = record.reachable_coverage_curve();
        self.describe_areas(curve.as_deref().unwrap_or_default(), record);
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

    fn describe_areas(&self, curve: &[f64], record: &mut ScanRecord) {
        let n_views = self.random.mean.len();
        let horizon = n_views as f64 * (MOVING_TIME + self.sensing_time);
        let time =
            |(i, step): (usize, &StepRecord)| step.trajectory_time_s + (i + 1) as f64 * self.sensing_time;
        let times: Vec<f64> = record.steps.iter().take(curve.len()).enumerate().map(time).collect();
        record.coverage_auc_views = area::over_views(curve, n_views);
        record.coverage_auc_time = area::over_time(curve, &times, horizon);
        record.coverage_auc_horizon_s = record.coverage_auc_time.map(|_| horizon);
    }
}
