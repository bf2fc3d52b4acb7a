use super::Situation;
use crate::flow::BestSets;
use crate::geometry::Pose;
use crate::visibility::{Paths, WorthCaster};
use rayon::prelude::*;
use std::sync::atomic::{AtomicUsize, Ordering};

/// What the views of a situation see.
pub(super) struct Survey {
    /// The local gain of every view, eq. (1); 0 for views that took no part.
    pub local: Vec<f64>,
    /// For every item of the caster, the views with a ray of largest quality, which is the maximum flow of eq. (3): only
    /// the source edges are bounded, so that each voxel's unit of flow takes its best ray without regard to the others.
    /// Without items where no flow is asked for.
    pub best: BestSets,
}

/// Views that a thread takes at a time: few, for their rays differ in number and length.
const SHARE: usize = 16;

impl Survey {
    /// Looks from all open views; visited ones take no part.
    pub fn new(situation: &Situation<'_>, caster: &WorthCaster<'_>, solves_flow: bool) -> Self {
        let (open, n_views) = (situation.open_views(), situation.views.len());
        let n_items = if solves_flow { caster.n_items() } else { 0 };
        let n_taken = AtomicUsize::new(0);
        let take = || {
            let start = n_taken.fetch_add(SHARE, Ordering::Relaxed).min(open.len());
            &open[start..open.len().min(start + SHARE)]
        };
        // As many parts as threads that come for a share: a part is large, and joining two is work.
        let parts = (0..rayon::current_num_threads()).into_par_iter().with_max_len(1).filter_map(|_| {
            let mut views = take();
            let mut part = (!views.is_empty()).then(|| Part::new(n_items, n_views))?;
            let mut paths = caster.paths();
            while !views.is_empty() {
                views
                    .iter()
                    .for_each(|&view| part.look(view, &situation.views.pose(view), caster, &mut paths));
                views = take();
            }
            Some(part)
        });
        let all = parts.reduce_with(Part::join).unwrap_or_else(|| Part::new(n_items, n_views));
        let mut local = vec![0.0; n_views];
        all.local.into_iter().for_each(|(view, gain)| local[view] = gain);
        Self { local, best: all.best }
    }
}

/// What some of the views see.
struct Part {
    /// By view, in no order.
    local: Vec<(usize, f64)>,
    best: BestSets,
    solves_flow: bool,
}

impl Part {
    fn new(n_items: usize, n_views: usize) -> Self {
        Self { local: Vec::new(), best: BestSets::new(n_items, n_views), solves_flow: n_items > 0 }
    }

    fn look(&mut self, view: usize, pose: &Pose, caster: &WorthCaster<'_>, paths: &mut Paths) {
        let local = if self.solves_flow {
            caster.cast(pose, paths, |item, quality| self.best.offer(item, view as u32, quality))
        } else {
            caster.cast(pose, paths, |_, _| ())
        };
        self.local.push((view, local));
    }

    /// The order of the parts does not show in the result.
    fn join(mut self, other: Self) -> Self {
        self.local.extend(other.local);
        self.best.merge(other.best);
        self
    }
}
