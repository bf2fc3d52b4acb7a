use crate::Cancelled;
use crate::gain::{ExpectedSurface, ViewEvaluator};
use crate::map::Snapshot;
use crate::planner::Situation;
use crate::prior::SurfaceEstimate;
use crate::visibility::MeasuredParts;
use rayon::prelude::*;

/// The setting in which views are compared.
pub(super) struct Setting<'a> {
    pub situation: &'a Situation<'a>,
    pub snapshot: &'a Snapshot,
    pub measured: &'a MeasuredParts,
    pub estimate: &'a SurfaceEstimate,
}

/// Survey of some views.
pub(super) struct SurfaceSurvey {
    /// Views with their expected gains, by increasing number.
    pub gains: Vec<(usize, f64)>,
    /// By voxel of the estimate, the largest probability that a view shows it.
    pub shown: Vec<f32>,
}

impl Setting<'_> {
    /// Surveys these views with rays `ray_spacing` voxels apart.
    pub fn survey(&self, views: &[usize], ray_spacing: f64) -> Result<SurfaceSurvey, Cancelled> {
        let gain = self.gain(ray_spacing);
        let nothing = || SurfaceSurvey { gains: Vec::new(), shown: vec![0.0; self.estimate.len()] };
        let parts = views.par_iter().try_fold(
            || (nothing(), gain.evaluator()),
            |(mut survey, mut evaluator), &view| {
                self.situation.cancel().check()?;
                survey.add(view, &mut evaluator, self.situation);
                Ok((survey, evaluator))
            },
        );
        let surveys = parts.map(|part| part.map(|(survey, _)| survey));
        let mut all = surveys.try_reduce(nothing, |a, b| Ok(a.join(b)))?;
        all.gains.sort_unstable_by_key(|(view, _)| *view);
        Ok(all)
    }

    /// Returns, by view, the voxels of the estimate that it shows, with their probabilities.
    pub fn shown(&self, views: &[usize], ray_spacing: f64) -> Result<Vec<Vec<(u32, f32)>>, Cancelled> {
        let gain = self.gain(ray_spacing);
        let look = |evaluator: &mut ViewEvaluator<'_>, &view: &usize| {
            self.situation.cancel().check()?;
            let mut shown = Vec::new();
            evaluator.shown(&self.situation.views().pose(view), |item, p| shown.push((item as u32, p)));
            Ok(shown)
        };
        views.par_iter().map_init(|| gain.evaluator(), look).collect()
    }

    fn gain(&self, ray_spacing: f64) -> ExpectedSurface<'_> {
        let (intrinsics, depth_range) = (self.situation.intrinsics(), self.situation.depth_range());
        let (snapshot, measured) = (self.snapshot, self.measured);
        let gain =
            ExpectedSurface::new(snapshot, intrinsics, depth_range, measured, self.estimate, ray_spacing);
        gain.expect("the constructor checked the number of rays")
    }
}

impl SurfaceSurvey {
    fn add(&mut self, view: usize, evaluator: &mut ViewEvaluator<'_>, situation: &Situation<'_>) {
        let mut gain = 0.0;
        evaluator.shown(&situation.views().pose(view), |item, p| {
            self.shown[item] = self.shown[item].max(p);
            gain += p as f64;
        });
        self.gains.push((view, gain));
    }

    fn join(mut self, other: Self) -> Self {
        self.gains.extend(other.gains);
        self.shown.iter_mut().zip(other.shown).for_each(|(a, b)| *a = a.max(b));
        self
    }
}
