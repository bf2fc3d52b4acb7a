use crate::flow::BestSets;
use crate::geometry::Pose;
use crate::planner::Situation;
use crate::visibility::{Paths, ValueCaster};
use crate::{Cancel, Cancelled};
use rayon::prelude::*;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Survey of the views of a situation.
pub(super) struct FlowSurvey {
    /// The local gain of every view, eq. (1); 0 for views not surveyed.
    pub local: Vec<f64>,
    /// For every item of the caster, the views with a ray of largest quality, which is the maximum flow of
    /// eq. (3): only the source edges are bounded, so each voxel's unit of flow takes its best ray
    /// independently of the others. Empty if no flow is requested.
    pub best: BestSets,
}

/// Number of views that a thread takes at a time: few, because their rays differ in number and length.
const SHARE: usize = 16;

impl FlowSurvey {
    /// Surveys all open views.
    pub fn new(
        situation: &Situation<'_>,
        caster: &ValueCaster<'_>,
        solves_flow: bool,
    ) -> Result<Self, Cancelled> {
        let cancel = situation.cancel();
        let (open, n_views) = (situation.open_views(), situation.views().len());
        let n_items = if solves_flow { caster.n_items() } else { 0 };
        let n_taken = AtomicUsize::new(0);
        let take = || {
            let start = n_taken.fetch_add(SHARE, Ordering::Relaxed).min(open.len());
            &open[start..open.len().min(start + SHARE)]
        };
        // About one part per thread: parts are large, and joining two is costly.
        let parts = (0..rayon::current_num_threads()).into_par_iter().with_max_len(1).filter_map(|_| {
            let mut views = take();
            let mut part = (!views.is_empty()).then(|| SurveyPart::new(n_items, n_views))?;
            let mut paths = caster.paths();
            while !views.is_empty() {
                for &view in views {
                    let pose = situation.views().pose(view);
                    if let Err(cancelled) = part.survey(view, &pose, caster, &mut paths, cancel) {
                        return Some(Err(cancelled));
                    }
                }
                views = take();
            }
            Some(Ok(part))
        });
        let all = parts.try_reduce_with(|a, b| a.join(b, cancel));
        let all = all.unwrap_or_else(|| Ok(SurveyPart::new(n_items, n_views)))?;
        let mut local = vec![0.0; n_views];
        all.local.into_iter().for_each(|(view, gain)| local[view] = gain);
        Ok(Self { local, best: all.best })
    }
}

/// Survey of some of the views.
struct SurveyPart {
    /// By view, in no order.
    local: Vec<(usize, f64)>,
    best: BestSets,
    solves_flow: bool,
}

impl SurveyPart {
    fn new(n_items: usize, n_views: usize) -> Self {
        Self { local: Vec::new(), best: BestSets::new(n_items, n_views), solves_flow: n_items > 0 }
    }

    fn survey(
        &mut self,
        view: usize,
        pose: &Pose,
        caster: &ValueCaster<'_>,
        paths: &mut Paths,
        cancel: &Cancel,
    ) -> Result<(), Cancelled> {
        let go_on = || cancel.check();
        let local = if self.solves_flow {
            let offer = |item, quality| self.best.offer(item, view as u32, quality);
            caster.cast_while(pose, paths, go_on, offer)?
        } else {
            caster.cast_while(pose, paths, go_on, |_, _| ())?
        };
        self.local.push((view, local));
        Ok(())
    }

    /// The order of the parts does not affect the result.
    fn join(mut self, other: Self, cancel: &Cancel) -> Result<Self, Cancelled> {
        self.local.extend(other.local);
        self.best.merge(other.best, cancel)?;
        Ok(self)
    }
}
