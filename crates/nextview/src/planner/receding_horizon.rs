use super::utility::check_ray_spacing;
use super::{Choice, Greedy, GreedyConfig, Plan, Situation, ViewPlanner};
use crate::gain::UnobservedVoxel;
use crate::geometry::random::Random;
use crate::motion::KeepOut;
use crate::{Cancelled, Error};
use glam::DVec3;

/// Grows a random tree of views from where the camera is and takes the first view of its best branch: the
/// receding horizon planner of Bircher et al. (ICRA 2016).
///
/// A view counts its [gain](UnobservedVoxel) times exp(-lambda c), where c is the length of the path from the
/// root. A branch counts the sum over its views. The rest of the best branch begins the next tree. There is
/// no choice if 200 views gain nothing.
///
/// In the publication, a robot flies through a building, and views are sampled anywhere. Here the nodes are
/// view candidates, paths go around the ball through the corners of the box, and lengths are in units of the
/// candidates' mean distance from the middle of the box.
#[derive(Clone, Debug)]
pub struct RecedingHorizon {
    gain: Greedy<UnobservedVoxel>,
    seed: u64,
    /// The best branch of the last plan after its first view.
    rest: Vec<usize>,
}

/// Discount of gains by the length of the path, in the unit of lengths (lambda).
const DISCOUNT: f64 = 0.5;

/// Largest length of an edge.
const MOST_EXTENSION: f64 = 0.5;

/// Number of views of a tree with any gain (N_max).
const N_VIEWS: usize = 15;

/// Number of views after which a tree without gain is abandoned (N_TOL).
const MOST_VIEWS: usize = 200;

/// Number of samples without a new view, per view of the tree, after which it stops growing.
const MOST_FAILURES: usize = 1000;

impl RecedingHorizon {
    /// Creates a planner with this ray spacing at the far side of the box, in voxels of the finest size, at
    /// least 0.1, and this seed for its trees.
    pub fn new(ray_spacing: f64, seed: u64) -> Result<Self, Error> {
        check_ray_spacing(ray_spacing)?;
        let gain = Greedy::new(GreedyConfig { ray_spacing, ..GreedyConfig::default() })?;
        Ok(Self { gain, seed, rest: Vec::new() })
    }
}

impl ViewPlanner for RecedingHorizon {
    fn plan(&mut self, situation: &Situation<'_>) -> Result<Plan, Error> {
        let open = situation.open_views();
        if open.is_empty() {
            return Ok(Plan::default());
        }
        let gains = self.gain.gains(situation, &open)?;
        let mut tree = ViewTree::new(situation, &open, &gains);
        tree.follow(&self.rest);
        tree.grow(&mut Random::new(self.seed, situation.visited().len() as u64), situation)?;
        let best = tree.best();
        self.rest = best.iter().skip(1).map(|node| node.view).collect();
        let choice = best.first().zip(best.last()).map(|(first, last)| Choice {
            explanation: Some(
                [
                    ("branch_length_m", last.path_length * tree.unit),
                    ("branch_views", best.len() as f64),
                    ("tree_views", tree.nodes.len() as f64),
                ]
                .into(),
            ),
            ..Choice::new(first.view, last.gain)
        });
        Ok(Plan { choice, ..Plan::default() })
    }
}

/// A tree of views with the position of the camera as its root.
struct ViewTree<'a> {
    situation: &'a Situation<'a>,
    ball: KeepOut,
    /// Mean distance of the open views from the middle of the box, metres: the unit of lengths.
    unit: f64,
    /// The views that are not in the tree, in increasing order, with their gains.
    open: Vec<(usize, f64)>,
    /// Every node comes after its parent.
    nodes: Vec<ViewNode>,
}

struct ViewNode {
    view: usize,
    position: DVec3,
    /// `None` for the root.
    parent: Option<usize>,
    /// Length of the path from the root, in units of the tree.
    path_length: f64,
    /// Gain of the branch that ends here.
    gain: f64,
}

impl<'a> ViewTree<'a> {
    fn new(situation: &'a Situation<'a>, open: &[usize], gains: &[f64]) -> Self {
        let bounds = situation.snapshot().lattice().bounds(&situation.snapshot().block());
        let ball = KeepOut::around(&bounds, 0.0).expect("a block of voxels is a finite box");
        let distance = |&view: &usize| situation.views().pose(view).translation().distance(ball.center());
        let unit = open.iter().map(distance).sum::<f64>() / open.len() as f64;
        let open = open.iter().copied().zip(gains.iter().copied()).collect();
        Self { situation, ball, unit, open, nodes: Vec::new() }
    }

    fn position(&self, view: usize) -> DVec3 {
        self.situation.views().pose(view).translation()
    }

    /// Length of the edge to a view, in units of the tree. Before the first view, the camera may be anywhere.
    fn edge(&self, parent: Option<usize>, to: DVec3) -> f64 {
        let from = parent.map(|parent| self.nodes[parent].position).or(self.situation.camera_position());
        from.map_or(0.0, |from| self.ball.path_length(from, to) / self.unit)
    }

    /// Adds the open view at this index of the list.
    fn add(&mut self, place: usize, parent: Option<usize>) {
        let (view, gain) = self.open.remove(place);
        let position = self.position(view);
        let (length_before, gain_before) =
            parent.map_or((0.0, 0.0), |parent| (self.nodes[parent].path_length, self.nodes[parent].gain));
        let path_length = length_before + self.edge(parent, position);
        let gain = gain_before + gain * (-DISCOUNT * path_length).exp();
        self.nodes.push(ViewNode { view, position, parent, path_length, gain });
    }

    /// Adds a branch up to the first view that is not open or too far away.
    fn follow(&mut self, branch: &[usize]) {
        for view in branch {
            let parent = self.nodes.len().checked_sub(1);
            let Some(place) = self.open.iter().position(|(open, _)| open == view) else { return };
            if self.edge(parent, self.position(*view)) > MOST_EXTENSION {
                return;
            }
            self.add(place, parent);
        }
    }

    /// Adds views towards random directions until there are enough.
    fn grow(&mut self, random: &mut Random, situation: &Situation<'_>) -> Result<(), Cancelled> {
        let mut n_failed = 0;
        while self.is_small() && n_failed < MOST_FAILURES * (self.nodes.len() + 1) {
            situation.cancel().check()?;
            let sample = random.in_cube();
            // Directions of points in a ball are uniform, those of points in a cube are not.
            let in_ball = sample.try_normalize().filter(|_| sample.length_squared() <= 1.0);
            let Some(direction) = in_ball else { continue };
            let target = self.ball.center() + direction * self.unit;
            let parent = self.nearest(target);
            match self.toward(parent, target) {
                Some(place) => self.add(place, parent),
                None => n_failed += 1,
            }
        }
        Ok(())
    }

    /// Whether the tree needs more views and any are left.
    fn is_small(&self) -> bool {
        let gains = self.nodes.iter().any(|node| node.gain > 0.0);
        !self.open.is_empty() && self.nodes.len() < if gains { N_VIEWS } else { MOST_VIEWS }
    }

    /// The node nearest to a position, the first on ties; `None` for the root.
    fn nearest(&self, target: DVec3) -> Option<usize> {
        let distance = |node: Option<usize>| {
            let from = node.map(|node| self.nodes[node].position).or(self.situation.camera_position());
            from.map_or(f64::INFINITY, |from| from.distance(target))
        };
        let nodes = (0..self.nodes.len()).map(Some);
        nodes.fold(None, |best, node| if distance(node) < distance(best) { node } else { best })
    }

    /// The index of the open view nearest to the target that an edge from the parent reaches, the first on
    /// ties.
    fn toward(&self, parent: Option<usize>, target: DVec3) -> Option<usize> {
        let places = (0..self.open.len()).map(|place| (place, self.position(self.open[place].0)));
        let within = places.filter(|(_, position)| self.edge(parent, *position) <= MOST_EXTENSION);
        let distance = |position: &DVec3| position.distance(target);
        within.min_by(|a, b| distance(&a.1).total_cmp(&distance(&b.1))).map(|(place, _)| place)
    }

    /// The branch of largest gain, the first on ties, from its first view on; empty if none gains anything.
    fn best(&self) -> Vec<&ViewNode> {
        let mut last: Option<&ViewNode> = None;
        for node in self.nodes.iter().filter(|node| node.gain > 0.0) {
            if last.is_none_or(|last| node.gain > last.gain) {
                last = Some(node);
            }
        }
        let mut branch: Vec<&ViewNode> =
            std::iter::successors(last, |node| node.parent.map(|parent| &self.nodes[parent])).collect();
        branch.reverse();
        branch
    }
}
