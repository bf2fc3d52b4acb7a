//! Alignment of all frames to each other at once.
//!
//! Frames aligned one after another accumulate errors: where the last one meets the first, around the object,
//! their surfaces are apart. Here, the pairs of every two frames are residuals of one least-squares problem
//! whose unknowns are the poses of all frames but the first (multi-view registration, Pulli 1999; a pose
//! graph whose edges are the point pairs).

use super::camera::FrameCamera;
use super::pair::Pair;
use super::point_tree::PointTree;
use super::surface_points::SurfacePoint;
use crate::geometry::{Pose, solve};
use crate::{Cancel, Cancelled};
use glam::{DQuat, DVec3};
use rayon::prelude::*;

/// Maximum number of points of a frame, evenly chosen, that are paired with each other frame.
const MOST_POINTS: usize = 400;

/// The weight of a pair falls to a quarter where the residual is this share of the reach.
const SCALE: f64 = 1.0 / 3.0;

/// Maximum number of steps; each searches for pairs again.
const MAX_STEPS: usize = 10;

/// Iteration ends when a step moves points by less than this share of the reach.
const SMALL_STEP: f64 = 5e-3;

/// The surface shown by a frame, and its poses.
#[derive(Clone, Debug)]
pub(super) struct JointView {
    /// In the camera frame.
    points: Vec<SurfacePoint>,
    /// Search tree of the same points.
    tree: PointTree,
    /// The pose in which the frame was added. Directions in which nothing holds it keep this pose.
    anchor: Pose,
    pub pose: Pose,
    /// The pose given with the frame.
    given: Pose,
    camera: FrameCamera,
}

impl JointView {
    /// Returns the view of a camera that shows these points, in its own frame, and its given pose; unless
    /// cancelled.
    pub fn new(
        points: Vec<SurfacePoint>,
        camera: FrameCamera,
        given: Pose,
        cancel: &Cancel,
    ) -> Result<Self, Cancelled> {
        let (tree, pose) = (PointTree::new(&points, cancel)?, camera.pose());
        Ok(Self { points, tree, anchor: pose, pose, given, camera })
    }

    /// Returns its camera in the current pose.
    pub fn camera(&self) -> FrameCamera {
        self.camera.at(self.pose)
    }

    /// Moves the view and its anchor.
    pub fn move_by(&mut self, motion: &Pose) {
        (self.pose, self.anchor) = (*motion * self.pose, *motion * self.anchor);
    }

    /// Returns some of its points, evenly chosen, in the current and in the given pose.
    pub fn placed_and_given(&self) -> impl Iterator<Item = [DVec3; 2]> + '_ {
        self.some_points()
            .map(|point| self.found_and_given().map(|pose| pose.transform_point(point.position)))
    }

    /// Returns the current and the given pose.
    pub fn found_and_given(&self) -> [Pose; 2] {
        [self.pose, self.given]
    }

    /// Returns the points in the world frame.
    pub fn world_points(&self) -> impl Iterator<Item = SurfacePoint> + '_ {
        self.points.iter().map(|point| point.moved(&self.pose))
    }

    /// Returns the motion of its points since `before`, root mean square, metres.
    pub fn moved_from(&self, before: &JointView) -> f64 {
        let moved = |point: &SurfacePoint| {
            let [now, then] = [self, before].map(|view| view.pose.transform_point(point.position));
            now.distance_squared(then)
        };
        let n = self.some_points().count().max(1) as f64;
        (self.some_points().map(moved).sum::<f64>() / n).sqrt()
    }

    fn some_points(&self) -> impl Iterator<Item = &SurfacePoint> {
        self.points.iter().step_by(self.points.len().div_ceil(MOST_POINTS).max(1))
    }

    /// Returns the pairs of another view's points with the surface of this one, in the world frame.
    fn pairs(&self, other: &JointView, reach: f64) -> Vec<Pair> {
        let here_from_other = self.pose.inverse() * other.pose;
        let pair = |point: &SurfacePoint| {
            let point = point.moved(&here_from_other);
            let nearest = self.tree.nearest(&point, reach)?;
            let normal = (point.normal + nearest.normal).normalize();
            Some(Pair {
                point: self.pose.transform_point(point.position),
                known: self.pose.transform_point(nearest.position),
                normal: self.pose.rotation() * normal,
            })
        };
        other.some_points().filter_map(pair).collect()
    }
}

/// Moves all views but the first so that their surfaces fit together, within `reach` metres. A view does not
/// move in directions with less than `min_stiffness`; see [`stiffness`](super::Registration::stiffness).
pub(super) fn align(
    views: &mut [JointView],
    reach: f64,
    min_stiffness: f64,
    cancel: &Cancel,
) -> Result<(), Cancelled> {
    for _ in 0..MAX_STEPS {
        let size = step(views, reach, min_stiffness, cancel)?;
        if size < SMALL_STEP * reach {
            break;
        }
    }
    Ok(())
}

/// Takes one Gauss-Newton step. Returns the largest motion of a view, metres.
fn step(views: &mut [JointView], reach: f64, min_stiffness: f64, cancel: &Cancel) -> Result<f64, Cancelled> {
    let n = views.len();
    let both: Vec<[usize; 2]> =
        (0..n).flat_map(|i| (0..n).map(move |j| [i, j])).filter(|[i, j]| i != j).collect();
    let pairs = both.par_iter().map(|&[i, j]| cancel.check().map(|()| views[i].pairs(&views[j], reach)));
    let pairs = pairs.collect::<Result<Vec<_>, _>>()?;
    let mut problem = StepEquations::new(views, pairs.iter().flatten());
    for ([i, j], pairs) in both.iter().zip(&pairs) {
        pairs.iter().for_each(|pair| problem.add(*i, *j, pair, SCALE * reach));
    }
    problem.hold(views, min_stiffness);
    Ok(problem.solve(views))
}

/// The normal equations of a step. The unknowns of a view are a rotation about the common middle, times the
/// radius, and a translation: six numbers in metres.
struct StepEquations {
    center: DVec3,
    radius: f64,
    /// Row by row, for all views but the first.
    squares: Vec<f64>,
    gradient: Vec<f64>,
    /// By view, the sum of the weights of its pairs.
    weights: Vec<f64>,
}

impl StepEquations {
    fn new<'a>(views: &[JointView], pairs: impl Iterator<Item = &'a Pair> + Clone) -> Self {
        let n = pairs.clone().count().max(1) as f64;
        let center = pairs.clone().map(|pair| pair.point).sum::<DVec3>() / n;
        let spread = pairs.map(|pair| pair.point.distance_squared(center)).sum::<f64>() / n;
        let size = 6 * (views.len() - 1);
        Self {
            center,
            radius: spread.sqrt().max(f64::MIN_POSITIVE.sqrt()),
            squares: vec![0.0; size * size],
            gradient: vec![0.0; size],
            weights: vec![0.0; views.len()],
        }
    }

    /// Adds the pair of a point of view `j` with the surface of view `i`.
    fn add(&mut self, i: usize, j: usize, pair: &Pair, scale: f64) {
        let weight = pair.weight(scale);
        let turn = (pair.point - self.center).cross(pair.normal) / self.radius;
        let along = [turn.x, turn.y, turn.z, pair.normal.x, pair.normal.y, pair.normal.z];
        for (view, sign) in [(j, 1.0), (i, -1.0)] {
            self.weights[view] += weight;
            self.add_gradient(view, along.map(|value| sign * weight * pair.residual() * value));
            for (other, other_sign) in [(j, 1.0), (i, -1.0)] {
                self.add_squares(view, other, |row, column| {
                    sign * other_sign * weight * along[row] * along[column]
                });
            }
        }
    }

    /// Pulls each view to its anchor, as strongly as a surface of this stiffness.
    fn hold(&mut self, views: &[JointView], min_stiffness: f64) {
        for (view, place) in views.iter().enumerate() {
            let weight = (min_stiffness * self.weights[view]).max(f64::MIN_POSITIVE.sqrt());
            let motion = place.pose * place.anchor.inverse();
            let rotation = motion.rotation();
            let turn = self.radius * (rotation * rotation.w.signum()).to_scaled_axis();
            let shift = motion.transform_point(self.center) - self.center;
            let moved = [turn.x, turn.y, turn.z, shift.x, shift.y, shift.z];
            self.add_gradient(view, moved.map(|value| weight * value));
            self.add_squares(view, view, |row, column| if row == column { weight } else { 0.0 });
        }
    }

    fn add_gradient(&mut self, view: usize, values: [f64; 6]) {
        if let Some(at) = (6 * view).checked_sub(6) {
            (0..6).for_each(|row| self.gradient[at + row] += values[row]);
        }
    }

    fn add_squares(&mut self, view: usize, other: usize, value: impl Fn(usize, usize) -> f64) {
        let size = self.gradient.len();
        if let (Some(top), Some(left)) = ((6 * view).checked_sub(6), (6 * other).checked_sub(6)) {
            for row in 0..6 {
                (0..6).for_each(|column| {
                    self.squares[(top + row) * size + left + column] += value(row, column)
                });
            }
        }
    }

    /// Moves the views. Returns the largest motion, metres.
    fn solve(self, views: &mut [JointView]) -> f64 {
        let Some(solution) = solve(self.squares, &self.gradient) else { return 0.0 };
        let mut largest: f64 = 0.0;
        for (view, step) in views[1..].iter_mut().zip(solution.chunks(6)) {
            let (turn, shift) = (-DVec3::from_slice(step), -DVec3::from_slice(&step[3..]));
            let turned = DQuat::from_scaled_axis(turn / self.radius);
            let motion = Pose::new(turned, shift + self.center - turned * self.center);
            view.pose = motion.expect("solutions of finite equations are finite") * view.pose;
            largest = largest.max((turn.length_squared() + shift.length_squared()).sqrt());
        }
        largest
    }
}
