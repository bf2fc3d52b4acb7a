use super::{GreedyConfig, Plan, Situation, ViewGain, ViewPlanner};
use crate::visibility::ViewRays;
use crate::{Cancelled, Error};
use rayon::prelude::*;

/// Takes the view of largest utility, as [`Greedy`](super::Greedy) does, by a gain that values all rays of a
/// view at once.
#[derive(Clone, Debug)]
pub struct GreedyByView<G> {
    config: GreedyConfig,
    gain: G,
}

/// Number of views whose rays are cast before they are evaluated: the rays of a view may take a megabyte.
const VIEWS_AT_ONCE: usize = 32;

impl<G: ViewGain> GreedyByView<G> {
    /// Creates a planner. Fails if a parameter is out of range.
    pub fn new(config: GreedyConfig, gain: G) -> Result<Self, Error> {
        config.check()?;
        Ok(Self { config, gain })
    }
}

impl<G: ViewGain> ViewPlanner for GreedyByView<G> {
    fn plan(&mut self, situation: &Situation<'_>) -> Result<Plan, Error> {
        let open = situation.open_views();
        let caster = self.config.caster(situation, self.gain.sight());
        self.gain.begin(situation)?;
        let mut gains = Vec::with_capacity(open.len());
        for views in open.chunks(VIEWS_AT_ONCE) {
            let cast = |&view: &usize| caster.rays(&situation.views().pose(view), situation.cancel());
            let cast: Result<Vec<ViewRays>, Cancelled> = views.par_iter().map(cast).collect();
            for (&view, rays) in views.iter().zip(&cast?) {
                situation.cancel().check()?;
                gains.push(self.gain.gain(situation, view, rays)?);
            }
        }
        Ok(self.config.plan(situation, &open, &gains))
    }
}
