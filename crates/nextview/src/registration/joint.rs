//! Alignment of all frames to each other at once.
//!
//! Frames aligned one after another accumulate errors: where the last one meets the first, around the object,
//! their surfaces are apart. Here, the pairs of every two frames and the given poses are residuals of one
//! least-squares problem whose unknowns are the poses of all frames and the error that the given poses share
//! (multi-view registration, Pulli 1999; a pose graph whose edges are the point pairs).

use super::SearchReach;
use super::joint_equations::JointEquations;
use super::pair::Pair;
use super::point_tree::PointTree;
use super::pose_fit::{HandEyeError, PoseFit};
use super::pose_prior::{PoseDeviation, PosePrior, difference};
use super::surface_points::SurfacePoint;
use crate::geometry::{Aabb, Pose};
use crate::{Cancel, Cancelled};
use glam::{DQuat, DVec3};
use rayon::prelude::*;

/// Maximum number of points of a frame, evenly chosen, that are paired with each other frame.
const MOST_POINTS: usize = 400;

/// The weight of a pair falls to a quarter where the residual is this share of the reach.
const SCALE: f64 = 1.0 / 3.0;

/// The reach after a step, as a share of the reach before.
const NARROWING: f64 = 0.7;

/// Maximum number of steps; each searches for pairs again.
const MAX_STEPS: usize = 20;

/// Iteration ends when a step moves points by less than this share of the last reach, and the deviation of
/// the given poses changes by less than this share.
const SMALL_STEP: f64 = 5e-3;
const SMALL_CHANGE: f64 = 0.1;

/// Share of the pairs that count as independent: neighbouring points share their errors of depth, and a point
/// has pairs in several frames.
const INDEPENDENT: f64 = 0.05;

/// Smallest deviation of a residual, as a share of the last reach: exact surfaces still differ by how they
/// are sampled.
const LEAST_NOISE: f64 = 0.01;

/// Depth errors that neighbouring points share, per square metre of distance: cameras that triangulate are
/// off in proportion to the square of the distance. That of a Kinect deviates by 1.425 mm at 1 m (Khoshelham
/// and Elberink, Sensors 2012), in steps of 2.8 mm.
const SYSTEMATIC: f64 = 1.425e-3;

/// Number of patches of the surface that two views both show whose systematic errors count as independent.
const PATCHES: f64 = 3.0;

/// The surface shown by a frame, and its poses.
#[derive(Clone, Debug)]
pub(super) struct JointView {
    /// In the camera frame.
    points: Vec<SurfacePoint>,
    /// Search tree of the same points.
    tree: PointTree,
    pub pose: Pose,
    /// The given pose, which the prior is about.
    pub given: Pose,
}

impl JointView {
    /// Returns the view of a camera in a pose that shows these points, in its own frame, and its given pose;
    /// unless cancelled.
    pub fn new(
        points: Vec<SurfacePoint>,
        pose: Pose,
        given: Pose,
        cancel: &Cancel,
    ) -> Result<Self, Cancelled> {
        let tree = PointTree::new(&points, cancel)?;
        Ok(Self { points, tree, pose, given })
    }

    /// Returns how far its points in the box are from where another pose puts them, root mean square, metres.
    pub fn moved_from(&self, pose: &Pose, bounds: Aabb) -> f64 {
        let points = self.some_points(bounds);
        let moved = |point: &SurfacePoint| {
            let [now, then] = [self.pose, *pose].map(|pose| pose.transform_point(point.position));
            now.distance_squared(then)
        };
        (points.iter().map(moved).sum::<f64>() / points.len().max(1) as f64).sqrt()
    }

    /// Returns some of its points in the box, evenly chosen.
    fn some_points(&self, bounds: Aabb) -> Vec<SurfacePoint> {
        let is_in = |point: &&SurfacePoint| bounds.contains(self.pose.transform_point(point.position));
        let inside: Vec<_> = self.points.iter().filter(is_in).copied().collect();
        inside.iter().step_by(inside.len().div_ceil(MOST_POINTS).max(1)).copied().collect()
    }

    /// Returns the pairs of points of another view with the surface of this one, in the world frame.
    fn pairs(&self, other: &JointView, points: &[SurfacePoint], reach: f64) -> Vec<Pair> {
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
        points.iter().filter_map(pair).collect()
    }
}

/// Moves all views to their most likely poses, given what they show in the box (world coordinates) and the
/// prior of their poses. The error that the poses share and the deviation of their own errors are found as
/// well. An error that the views do not clearly show is not assumed: it would bend and displace the surface
/// by chance. Returns how well the views fit together.
pub(super) fn align(
    views: &mut [&mut JointView],
    prior: &mut PosePrior,
    bounds: Aabb,
    reach: SearchReach,
    cancel: &Cancel,
) -> Result<PoseFit, Cancelled> {
    let points: Vec<_> = views.iter().map(|view| view.some_points(bounds)).collect();
    let mut fit = settle(views, prior, &points, reach, cancel)?;
    let mut assumed = *prior;
    if prior.may_share_error && !fit.hand_eye.is_some_and(|hand_eye| hand_eye.is_shown()) {
        assumed = prior.without_shared_error();
        let reach = SearchReach { first: reach.last, ..reach };
        fit = PoseFit { hand_eye: fit.hand_eye, ..settle(views, &mut assumed, &points, reach, cancel)? };
    }
    place(views, &assumed, &fit, &points);
    Ok(fit)
}

/// Moves all views to their most likely poses, given these points of theirs and the prior.
fn settle(
    views: &mut [&mut JointView],
    prior: &mut PosePrior,
    points: &[Vec<SurfacePoint>],
    reach: SearchReach,
    cancel: &Cancel,
) -> Result<PoseFit, Cancelled> {
    let systematic: Vec<_> = points.iter().map(|points| systematic_variance(points)).collect();
    let in_common = systematic_deviation(points, &systematic);
    let mut distance = reach.first;
    let mut both: Vec<[usize; 2]> = (0..views.len())
        .flat_map(|i| (0..views.len()).map(move |j| [i, j]))
        .filter(|[i, j]| i != j)
        .collect();
    let mut fit = PoseFit::default();
    for _ in 0..MAX_STEPS {
        let pairs = both
            .par_iter()
            .map(|&[i, j]| cancel.check().map(|()| views[i].pairs(views[j], &points[j], distance)));
        let pairs = pairs.collect::<Result<Vec<_>, _>>()?;
        let (scale, least_noise) = (SCALE * distance, LEAST_NOISE * reach.last);
        let certainties = certainties(&systematic, &both, &pairs, scale, least_noise);
        let equations = equations(views, prior, &both, &pairs, &certainties, scale).factored();
        let Some((step, equations)) = equations.and_then(|equations| Some((equations.step()?, equations)))
        else {
            break;
        };
        let is_settled = distance <= reach.last
            && equations.own_deviation().is_none_or(|shown| prior.adopt_own(shown) < SMALL_CHANGE);
        let (given_residual, certainty_wrong) =
            compared_to_given(views, &both, &pairs, &certainties, scale).unzip();
        for (number, (view, motion)) in views.iter_mut().zip(step.motions).enumerate() {
            if !prior.is_exact(number) {
                view.pose = motion * view.pose;
            }
        }
        prior.given_from_camera = prior.given_from_camera * step.of_shared;
        let shared = equations.shared_deviation();
        let hand_eye = prior.may_share_error.then_some(HandEyeError {
            given_from_camera: prior.given_from_camera,
            position_deviation: shared.position.hypot(in_common.position),
            rotation_deviation: shared.rotation.hypot(in_common.rotation),
        });
        fit = PoseFit {
            residuals: residuals(views.len(), &both, &pairs, scale),
            hand_eye,
            given_residual,
            certainty_wrong: certainty_wrong.unwrap_or(0.0),
            systematic: in_common.position,
        };
        if is_settled && step.size < SMALL_STEP * reach.last {
            break;
        }
        // What does not meet within this reach does not meet within a smaller one.
        let mut has_pairs = pairs.iter().map(|pairs| !pairs.is_empty());
        both.retain(|_| has_pairs.next().unwrap_or(false));
        distance = (NARROWING * distance).max(reach.last);
    }
    Ok(fit)
}

/// Moves all views that meet others as one, to where their prior puts them on average: the middle of these
/// points of theirs, and the directions of the cameras. A view that meets no other lies there itself. An
/// exact pose stays, and with it all others.
///
/// Frames determine their poses to each other only. The most likely common place would depend on where errors
/// of rotation turn about: those of a robot at the camera, those of poses found by markers around the object
/// at the object. The middle of the points is right for both.
fn place(views: &mut [&mut JointView], prior: &PosePrior, fit: &PoseFit, points: &[Vec<SurfacePoint>]) {
    if (0..views.len()).any(|number| prior.is_exact(number)) {
        return;
    }
    let (mut turn, mut n_views, mut middles, mut n_points) = (DVec3::ZERO, 0, [DVec3::ZERO; 2], 0);
    for (number, (view, points)) in views.iter_mut().zip(points).enumerate() {
        let mean = prior.mean(number, &view.given);
        if fit.residuals.get(number).is_none_or(Option::is_none) {
            view.pose = mean;
            continue;
        }
        turn += difference(&Pose::IDENTITY, &(mean * view.pose.inverse()))[0];
        n_views += 1;
        for (sum, pose) in middles.iter_mut().zip([view.pose, mean]) {
            *sum += points.iter().map(|point| pose.transform_point(point.position)).sum::<DVec3>();
        }
        n_points += points.len();
    }
    let turn = DQuat::from_scaled_axis(turn / f64::from(n_views.max(1)));
    let [from, to] = middles.map(|sum| sum / n_points.max(1) as f64);
    let motion = Pose::new(turn, to - turn * from).expect("finite points have a mean");
    let meet = views.iter_mut().zip(&fit.residuals).filter(|(_, residual)| residual.is_some());
    meet.for_each(|(view, _)| view.pose = motion * view.pose);
}

/// Returns the variance of the error, square metres, that a camera's depths of these points, in its frame,
/// have in common.
fn systematic_variance(points: &[SurfacePoint]) -> f64 {
    let mean = points.iter().map(|point| point.position.z).sum::<f64>() / points.len().max(1) as f64;
    (SYSTEMATIC * mean * mean).powi(2)
}

/// Returns the deviation of an error that all views have in common because their depths of these points have
/// errors of these variances, square metres: such errors move and tilt the surface, as a wrong calibration
/// does.
fn systematic_deviation(points: &[Vec<SurfacePoint>], systematic: &[f64]) -> PoseDeviation {
    let tilt_sq = |(points, variance): (&Vec<SurfacePoint>, &f64)| {
        let middle = points.iter().map(|point| point.position).sum::<DVec3>() / points.len() as f64;
        let from_middle = |point: &SurfacePoint| (point.position - middle).truncate().length_squared();
        variance * points.len() as f64 / points.iter().map(from_middle).sum::<f64>()
    };
    let showing: Vec<_> = points.iter().zip(systematic).filter(|(points, _)| points.len() > 1).collect();
    let n = showing.len().max(1) as f64;
    PoseDeviation {
        position: (showing.iter().map(|(_, variance)| **variance).sum::<f64>() / n).sqrt(),
        rotation: (showing.into_iter().map(tilt_sq).sum::<f64>() / n).sqrt(),
    }
}

/// Returns how certain the pairs of every two views are: the inverse of a pair's variance, a square metre,
/// for robust weights for this scale. Noise has at least a deviation of `least_noise` metres.
///
/// More pairs make two views no more certain than their systematic errors allow.
fn certainties(
    systematic: &[f64],
    both: &[[usize; 2]],
    pairs: &[Vec<Pair>],
    scale: f64,
    least_noise: f64,
) -> Vec<f64> {
    let most = INDEPENDENT / noise_variance(pairs.iter().flatten(), scale, least_noise);
    let certainty = |([i, j], pairs): (&[usize; 2], &Vec<Pair>)| {
        let of_all = most * pairs.iter().map(|pair| pair.weight(scale)).sum::<f64>();
        most / (1.0 + of_all * (systematic[*i] + systematic[*j]) / PATCHES)
    };
    both.iter().zip(pairs).map(certainty).collect()
}

/// Returns the equations of these pairs, with these certainties and robust weights for this scale, and of the
/// prior.
fn equations(
    views: &[&mut JointView],
    prior: &PosePrior,
    both: &[[usize; 2]],
    pairs: &[Vec<Pair>],
    certainties: &[f64],
    scale: f64,
) -> JointEquations {
    let mut equations = JointEquations::new(views.len(), pairs.iter().flatten());
    for (([i, j], pairs), certainty) in both.iter().zip(pairs).zip(certainties) {
        pairs.iter().for_each(|pair| equations.add_pair(*i, *j, pair, certainty * pair.weight(scale)));
    }
    for (number, view) in views.iter().enumerate() {
        equations.add_pose(number, &view.pose, &view.given, prior);
    }
    equations.add_shared_error(prior);
    equations
}

/// Returns the root mean square of the residuals of each view, with weights for this scale.
fn residuals(n_views: usize, both: &[[usize; 2]], pairs: &[Vec<Pair>], scale: f64) -> Vec<Option<f64>> {
    let mut sums = vec![(0.0, 0.0); n_views];
    for (both, pairs) in both.iter().zip(pairs) {
        for pair in pairs {
            let weight = pair.weight(scale);
            for view in both {
                sums[*view].0 += weight * pair.residual().powi(2);
                sums[*view].1 += weight;
            }
        }
    }
    sums.iter().map(|(squares, total)| (*total > 0.0).then(|| (squares / total).sqrt())).collect()
}

/// Returns the root mean square of the residuals in the given poses, metres, and by how many standard
/// deviations the alignment improves the fit more than that of exact poses; `None` if there are no pairs.
/// Weights are those of the residuals in the current poses.
///
/// If the given poses are exact, the alignment lowers the sum of the squares, each times its certainty, by a
/// chi-squared variable with as many degrees of freedom as the poses have to each other.
fn compared_to_given(
    views: &[&mut JointView],
    both: &[[usize; 2]],
    pairs: &[Vec<Pair>],
    certainties: &[f64],
    scale: f64,
) -> Option<(f64, f64)> {
    let (mut squares, mut total, mut gain) = (0.0, 0.0, 0.0);
    let to_given: Vec<Pose> = views.iter().map(|view| view.given * view.pose.inverse()).collect();
    for (([i, j], pairs), certainty) in both.iter().zip(pairs).zip(certainties) {
        for pair in pairs {
            let weight = pair.weight(scale);
            let apart = to_given[*j].transform_point(pair.point) - to_given[*i].transform_point(pair.known);
            let given_sq = (to_given[*i].rotation() * pair.normal).dot(apart).powi(2);
            squares += weight * given_sq;
            total += weight;
            gain += certainty * weight * (given_sq - pair.residual().powi(2));
        }
    }
    let freedom = 6.0 * (views.len() as f64 - 1.0);
    (total > 0.0).then(|| ((squares / total).sqrt(), (gain - freedom) / (2.0 * freedom).sqrt()))
}

/// Returns the variance of the residuals, square metres, with weights for this scale, at least that of a
/// deviation of `least` metres.
fn noise_variance<'a>(pairs: impl Iterator<Item = &'a Pair>, scale: f64, least: f64) -> f64 {
    let add = |(squares, total): (f64, f64), pair: &Pair| {
        let weight = pair.weight(scale);
        (squares + weight * pair.residual().powi(2), total + weight)
    };
    let (squares, total) = pairs.fold((0.0, 0.0), add);
    (squares / total.max(f64::MIN_POSITIVE)).max(least * least)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::random::Random;
    use crate::registration::RegistrationConfig;
    use crate::view::look_at;
    use glam::{DQuat, DVec3};
    use std::f64::consts::{FRAC_1_SQRT_2, FRAC_PI_2};

    /// Points of a pyramid, 80 mm wide and 40 mm high, that face the camera, in its frame, with noise. All
    /// its sides are seen from above.
    fn shown(world_from_camera: &Pose, noise: f64, random: &mut Random) -> Vec<SurfacePoint> {
        let camera_from_world = world_from_camera.inverse();
        let point = |_| {
            let (up, across) = (random.unit(), random.range(-1.0, 1.0));
            let side = DQuat::from_rotation_z(FRAC_PI_2 * random.index(4) as f64);
            let position = side * (0.04 * DVec3::new(1.0 - up, (1.0 - up) * across, up));
            let normal = side * DVec3::new(FRAC_1_SQRT_2, 0.0, FRAC_1_SQRT_2);
            let to_camera = world_from_camera.translation() - position;
            let position = position + noise * random.normal() * normal;
            (normal.dot(to_camera) > 0.05 * to_camera.length())
                .then(|| SurfacePoint { position, normal }.moved(&camera_from_world))
        };
        (0..20_000).filter_map(point).collect()
    }

    fn moved(turn: DVec3, shift: DVec3) -> Pose {
        Pose::new(DQuat::from_scaled_axis(turn), shift).unwrap()
    }

    /// Twelve views from near and far, with these errors of the given poses, and their true poses.
    fn views(seed: u64, own: f64, shared: &Pose) -> (Vec<JointView>, Vec<Pose>) {
        let mut random = Random::new(seed, 0);
        let view = |i: usize| {
            let (azimuth, up) = (2.4 * i as f64, [0.7, 1.0, 1.4][i % 3]);
            let direction =
                DVec3::new(azimuth.cos() * f64::cos(up), azimuth.sin() * f64::cos(up), f64::sin(up));
            let truth = look_at([0.25, 0.4][i % 2] * direction, DVec3::ZERO).unwrap()
                * moved(DVec3::Z * i as f64, DVec3::ZERO);
            let error = moved(own / 0.4 * random.in_cube(), own * random.in_cube());
            // The given pose is the true one without the shared error.
            let given = truth * error * shared.inverse();
            let points = shown(&truth, 2e-4, &mut random);
            (JointView::new(points, given, given, &Cancel::default()).unwrap(), truth)
        };
        (0..12).map(view).unzip()
    }

    const BOUNDS: Aabb = Aabb { min: DVec3::splat(-0.1), max: DVec3::splat(0.1) };
    const REACH: SearchReach = SearchReach { first: 0.04, last: 0.003 };

    /// Returns the largest distance between where two lists of poses put corners of the box, metres.
    fn apart(poses: &[Pose], truths: &[Pose]) -> f64 {
        let off = |(pose, truth): (&Pose, &Pose)| {
            let motion = *pose * truth.inverse();
            let corners = Aabb::cube(DVec3::ZERO, 0.04).corners();
            corners
                .map(|corner| motion.transform_point(corner).distance(corner))
                .into_iter()
                .fold(0.0, f64::max)
        };
        poses.iter().zip(truths).map(off).fold(0.0, f64::max)
    }

    /// Moves poses so that the first is the true one.
    fn as_first(poses: &[Pose], truths: &[Pose]) -> Vec<Pose> {
        let motion = truths[0] * poses[0].inverse();
        poses.iter().map(|pose| motion * *pose).collect()
    }

    #[test]
    fn an_error_that_all_poses_share_is_found_with_their_own() {
        for seed in 0..3 {
            let shared = moved(DVec3::new(0.02, -0.01, 0.015), DVec3::new(0.004, -0.003, 0.005));
            let (mut views, truths) = views(seed, 1e-3, &shared);
            let mut prior = PosePrior::new(&RegistrationConfig::default());
            let fit = align(
                &mut views.iter_mut().collect::<Vec<_>>(),
                &mut prior,
                BOUNDS,
                REACH,
                &Cancel::default(),
            )
            .unwrap();
            let poses: Vec<_> = views.iter().map(|view| view.pose).collect();
            let off = apart(&as_first(&poses, &truths), &truths);
            let left = shared.inverse() * prior.given_from_camera;
            let turned = left.rotation().to_axis_angle().1;
            println!(
                "views {:.3} mm apart; shared error off by {:.3} mm, {:.3} degrees",
                1e3 * off,
                1e3 * left.translation().length(),
                turned.to_degrees()
            );
            assert!(off < 3e-4 && left.translation().length() < 1e-3 && turned < 3e-3);
            let hand_eye = fit.hand_eye.unwrap();
            assert!(left.translation().length() < 3.0 * hand_eye.position_deviation);
            assert!(turned < 3.0 * hand_eye.rotation_deviation && hand_eye.is_shown());
            // Errors of up to 1 mm on each axis deviate by 1 / sqrt(3).
            let own = prior.deviation(1).position;
            assert!((3e-4..9e-4).contains(&own), "{own}");
            let residual = fit.residual().unwrap();
            assert!((1e-4..4e-4).contains(&residual), "{residual}");
        }
    }

    #[test]
    fn exact_poses_seem_exact_and_wrong_ones_wrong() {
        let certainty = |seed: u64, own: f64, n: usize| {
            let (mut views, _) = views(seed, own, &Pose::IDENTITY);
            let mut views: Vec<_> = views.iter_mut().take(n).collect();
            let mut prior = PosePrior::new(&RegistrationConfig::default());
            align(&mut views, &mut prior, BOUNDS, REACH, &Cancel::default()).unwrap().certainty_wrong
        };
        for seed in 0..3 {
            for n in [2, 3, 4, 8, 12] {
                let certainty = certainty(seed, 0.0, n);
                assert!(certainty < 1.0, "{n} views: {certainty}");
            }
            for n in [4, 8, 12] {
                let certainty = certainty(seed, 1e-3, n);
                assert!(certainty > 3.0, "{n} views: {certainty}");
            }
        }
    }

    #[test]
    fn a_view_that_meets_no_other_moves_with_the_shared_error_only() {
        let shared = moved(DVec3::ZERO, DVec3::new(0.003, 0.0, 0.004));
        let (mut views, _) = views(5, 0.0, &shared);
        let alone = JointView::new(Vec::new(), views[3].given, views[3].given, &Cancel::default()).unwrap();
        views.push(alone);
        let mut prior = PosePrior::new(&RegistrationConfig::default());
        align(&mut views.iter_mut().collect::<Vec<_>>(), &mut prior, BOUNDS, REACH, &Cancel::default())
            .unwrap();
        let expected = views[3].given * prior.given_from_camera;
        assert!(apart(&[views[12].pose], &[expected]) < 1e-6);
    }

    #[test]
    fn an_exact_first_pose_stays_to_the_bit() {
        let (mut views, _) = views(6, 1e-3, &Pose::IDENTITY);
        let first = views[0].pose;
        let given_poses = crate::registration::GivenPoses::FirstIsRight;
        let mut prior = PosePrior::new(&RegistrationConfig { given_poses, ..RegistrationConfig::default() });
        align(&mut views.iter_mut().collect::<Vec<_>>(), &mut prior, BOUNDS, REACH, &Cancel::default())
            .unwrap();
        assert_eq!(views[0].pose, first);
    }
}
