use super::Slips;
use super::gain::Qualities;
use super::rays::PlanningRays;
use nextview::flow::BestSets;
use nextview::geometry::random::Random;

/// Minimum quality, exclusive, that enters the flow in the authors' program.
const THRESHOLD: f64 = 0.3;

/// Returns for every voxel of a box of `n_voxels` its largest quality and the views that offer it: all
/// optimal flows of eq. (3), in which every voxel independently takes a ray of largest quality.
pub fn optimal_views(
    qualities: &Qualities,
    rays: &PlanningRays,
    n_voxels: usize,
    slips: Slips,
    is_visited: impl Fn(usize) -> bool,
) -> BestSets {
    let mut best = BestSets::new(n_voxels, rays.of_view.len());
    for (view, numbers) in rays.of_view.iter().enumerate() {
        if !slips.visited_in_flow && is_visited(view) {
            continue;
        }
        for &ray in numbers {
            for (voxel, quality) in in_flow(qualities, &rays.voxels[ray as usize], slips) {
                best.offer(voxel as usize, view as u32, quality);
            }
        }
    }
    best
}

/// Returns the voxels of a ray that are in the network, with their qualities.
pub fn in_flow(qualities: &Qualities, voxels: &[u32], slips: Slips) -> impl Iterator<Item = (u32, f64)> {
    let threshold = if slips.flow_above_threshold { THRESHOLD } else { 0.0 };
    qualities.along(voxels).filter(move |&(_, quality)| quality > threshold)
}

/// The choice among a voxel's optimal views of the one that takes its unit of flow. In the authors' program
/// it depends on thread timing and on the solver's order of work.
#[derive(Clone, Debug)]
pub enum Ties {
    /// Drawn again for every plan.
    Anew(Random),
    /// Drawn once for a run, from this number: every plan takes the same one of the same views.
    Lasting(u64),
}

impl Ties {
    /// Returns the views that carry one of the optimal flows, V_global, in increasing order.
    pub fn views(&mut self, best: &BestSets, n_voxels: usize) -> Vec<u32> {
        let mut views: Vec<u32> = (0..n_voxels).filter_map(|voxel| self.view(best, voxel)).collect();
        views.sort_unstable();
        views.dedup();
        views
    }

    fn view(&mut self, best: &BestSets, voxel: usize) -> Option<u32> {
        let optimal: Vec<u32> = best.sets(voxel).collect();
        match self {
            _ if optimal.is_empty() => None,
            Self::Anew(draw) => Some(optimal[draw.index(optimal.len())]),
            Self::Lasting(order) => {
                let rank = |view: u32| Random::new(*order, (voxel as u64) << 32 | u64::from(view)).unit();
                optimal.into_iter().min_by(|&a, &b| rank(a).total_cmp(&rank(b)).then(a.cmp(&b)))
            }
        }
    }
}

/// Returns the flow gain of every view, eqs. (4) and (5), from V_global of every plan, the current one last.
pub fn flow_gains(plans: &[Vec<u32>], n_views: usize, slips: Slips) -> Vec<f64> {
    let mut gains = vec![0.0; n_views];
    for (k, views) in plans.iter().enumerate() {
        for &view in views {
            let age = if slips.history_by_view_number {
                f64::from(view) - k as f64
            } else {
                (plans.len() - 1 - k) as f64
            };
            gains[view as usize] += (-age).exp();
        }
    }
    gains
}
