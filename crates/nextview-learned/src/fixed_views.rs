//! Views around the box in fixed directions, for the choice and the training of networks.

use glam::DVec3;
use nextview::Error;
use nextview::geometry::{Aabb, Pose};
use nextview::planner::{Choice, Situation};
use nextview::view::look_at;

/// Distance of the views from the centre of the box, in halves of its longest side: the middle of the paper's
/// shell of candidates.
pub const DISTANCE: f64 = 2.5;

/// Returns the positions of cameras in these directions around a box, metres.
pub fn positions(bounds: &Aabb, directions: &[DVec3]) -> Vec<DVec3> {
    let distance = 0.5 * DISTANCE * bounds.longest_side();
    directions.iter().map(|direction| bounds.center() + distance * direction).collect()
}

/// Returns the poses of cameras that look at the centre of the box. Fails if one is beyond [`Pose::REACH`].
pub fn poses(bounds: &Aabb, directions: &[DVec3]) -> Result<Vec<Pose>, Error> {
    positions(bounds, directions).into_iter().map(|position| look_at(position, bounds.center())).collect()
}

/// The reachable candidate nearest to each view, visited or not, the first on ties; `None` if no candidate is
/// within reach.
pub(crate) fn stand_ins(situation: &Situation<'_>, directions: &[DVec3]) -> Vec<Option<usize>> {
    let (snapshot, views) = (situation.snapshot(), situation.views());
    let bounds = snapshot.lattice().bounds(&snapshot.block());
    let nearest = |position: DVec3| {
        let candidates = (0..views.len()).filter(|&view| situation.can_go(view));
        let distances =
            candidates.map(|view| (views.pose(view).translation().distance_squared(position), view));
        distances.min_by(|(a, _), (b, _)| a.total_cmp(b)).map(|(_, view)| view)
    };
    positions(&bounds, directions).into_iter().map(nearest).collect()
}

/// Chooses an unvisited candidate: the one that stands for the view with the highest score, the first on
/// ties. The runner-up is the next different candidate. Views without a score are left out.
pub(crate) fn choice(
    situation: &Situation<'_>,
    stand_ins: &[Option<usize>],
    scores: &[Option<f64>],
) -> Option<Choice> {
    let is_open = |candidate: &usize| !situation.visited().contains(candidate);
    let scored = stand_ins.iter().zip(scores);
    let mut open: Vec<(usize, f64)> =
        scored.filter_map(|(candidate, &score)| Some((candidate.filter(is_open)?, score?))).collect();
    open.sort_by(|(_, a), (_, b)| b.total_cmp(a));
    let &(best, score) = open.first()?;
    let runner_up = open.iter().map(|&(other, _)| other).find(|&other| other != best);
    Some(Choice { runner_up, ..Choice::new(best, score) })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::nbv_net::views::DIRECTIONS;

    #[test]
    fn views_stand_around_the_box_and_look_at_its_centre() {
        let bounds = Aabb { min: DVec3::new(0.1, 0.0, -0.1), max: DVec3::new(0.3, 0.1, 0.0) };
        for (pose, direction) in poses(&bounds, &DIRECTIONS).unwrap().iter().zip(DIRECTIONS) {
            let offset = pose.translation() - bounds.center();
            assert!((offset.length() - 0.25).abs() < 1e-12);
            assert!(offset.normalize().distance(direction) < 1e-12);
            assert!((pose.rotation() * DVec3::Z).distance(-direction) < 1e-12);
        }
    }
}
