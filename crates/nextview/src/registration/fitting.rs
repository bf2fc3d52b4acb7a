//! Finds the pose in which a frame fits the known surface: from points that lie on it, and from space that
//! cameras saw as free.

use super::camera::FrameCamera;
use super::icp::{Hold, SearchReach, align, align_where_held, pairs};
use super::normal_equations::NormalEquations;
use super::pair::Pair;
use super::point_tree::PointTree;
use super::surface_points::SurfacePoint;
use super::{GivenPoses, Registration, RegistrationConfig, Verdict};
use crate::geometry::{Eigen, Pose};
use crate::{Cancel, Cancelled};
use glam::{DQuat, DVec3};
use rayon::prelude::*;

/// Initial search distances of an alignment, as shares of the given pose's uncertainty: distant points
/// without overlap pull a nearly correct frame to a wrong place. Among poses of about the same misfit, up to
/// this factor, the first, and thus nearest, is chosen.
const FIRST_REACHES: [f64; 3] = [0.25, 0.5, 1.0];
const CLEARLY_WORSE: f64 = 1.05;

/// Stiffness above which a direction is firm: a table holds a frame up and level.
const FIRM: f64 = 0.05;

/// Share of contradicting points up to which no search is needed.
const MAY_CONTRADICT: f64 = 0.01;

/// Share of the surface facing an axis above which no search along it is needed.
const MOST: f64 = 0.5;

/// The search covers the position's uncertainty in this many steps each way, uses every n-th point, and
/// continues from this number of places.
const N_STEPS: usize = 4;
const EVERY: usize = 5;
const N_LIKELY: usize = 12;

/// Share of the required stiffness that is enough after the search: the frame cannot move far any more.
const LOOSELY: f64 = 0.1;

/// Cost of a turn after the search, first from the given pose, then from the best place: as if each point
/// were off by the turn (radians) times this length, metres. Without this cost, with little overlap, mostly
/// table, a frame turns as far as allowed. A degree costs 0.07 mm, less than the noise, and the largest turn
/// allowed by default 0.7 mm.
const TURN_ARM: f64 = 0.004;

/// Weight of a point that is not known yet, relative to a contradicting one: it is worse than one that fits.
const NEW: f64 = 0.25;

/// Minimum number of points on the known surface for an overlap, whatever their share.
const LEAST_PAIRS: usize = 50;

/// A frame and the surface shown by earlier frames.
pub(super) struct Fitting<'a> {
    pub config: &'a RegistrationConfig,
    /// Search distances; points within the last one lie on the surface.
    pub reach: SearchReach,
    /// The points of the frame, in the camera frame.
    pub points: Vec<SurfacePoint>,
    /// The frame's camera, in the given pose.
    pub camera: FrameCamera,
    /// The known points, world coordinates.
    pub known: Vec<DVec3>,
    /// Search tree of the known points.
    pub tree: &'a PointTree,
    /// The cameras that have shown the known points.
    pub earlier: Vec<FrameCamera>,
    pub cancel: &'a Cancel,
}

/// A frame in its given pose compared with the known surface.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PoseComparison {
    /// The alignment from the given pose.
    pub found: Registration,
    /// Root mean square distance, metres, of the frame's points from the known surface in the given pose. A
    /// point that is on the surface only after the alignment counts as the whole reach. Pairs found by the
    /// alignment would overstate it for a frame that slides along a surface.
    pub apart: f64,
}

/// A frame in a pose, before any objections.
#[derive(Clone, Copy, Debug)]
struct FrameFit {
    registration: Registration,
    /// Number of its points that lie on the known surface.
    n_pairs: usize,
    n_contradictions: usize,
    /// Square metres.
    misfit: f64,
}

impl Fitting<'_> {
    /// Returns the best fit, or the given pose and the objection to the fit.
    pub fn register(&self) -> Result<Registration, Cancelled> {
        let best = self.best()?;
        Ok(match self.objection(&best)? {
            Some(verdict) => {
                Registration { world_from_camera: self.camera.pose(), verdict, ..best.registration }
            }
            None => best.registration,
        })
    }

    /// Aligns the frame from its given pose alone, without a search. It is refused only if it fits no better
    /// than in the given pose.
    pub fn nearby(&self) -> Result<PoseComparison, Cancelled> {
        let FrameFit { registration, n_pairs, misfit, .. } = self.aligned(self.reach.first)?;
        let given = self.camera.pose();
        let verdict = if misfit < self.misfit(&given)? { registration.verdict } else { Verdict::NoBetter };
        let before = self.pairs(&given, self.reach.last)?;
        let n = before.len().max(n_pairs);
        let squares: f64 = before.iter().map(|pair| pair.residual().powi(2)).sum();
        let lost = self.reach.last.powi(2) * (n - before.len()) as f64;
        let apart = ((squares + lost) / n.max(1) as f64).sqrt();
        Ok(PoseComparison { found: Registration { verdict, ..registration }, apart })
    }

    /// Returns the nearest of the alignments with about the least misfit, preferring those within the given
    /// pose's uncertainty.
    fn best(&self) -> Result<FrameFit, Cancelled> {
        let mut firsts = FIRST_REACHES.map(|share| (share * self.reach.first).max(self.reach.last)).to_vec();
        firsts.dedup();
        let mut fits = firsts.iter().map(|first| self.aligned(*first)).collect::<Result<Vec<_>, _>>()?;
        let is_near = |fit: &FrameFit| self.is_near(&fit.registration.world_from_camera);
        let few = (MAY_CONTRADICT * self.points.len() as f64) as usize;
        let is_consistent = |fit: &FrameFit| is_near(fit) && fit.n_contradictions <= few;
        if self.points.len() >= LEAST_PAIRS && !fits.iter().any(is_consistent) {
            fits.extend(self.searched()?);
        }
        if fits.iter().any(is_near) {
            fits.retain(is_near);
        }
        let least = fits.iter().map(|fit| fit.misfit).fold(f64::INFINITY, f64::min);
        let nearest = fits.into_iter().find(|fit| fit.misfit <= CLEARLY_WORSE * least);
        Ok(nearest.expect("the least misfit is no worse than itself"))
    }

    /// Aligns the frame from the given pose with this initial search distance.
    fn aligned(&self, first: f64) -> Result<FrameFit, Cancelled> {
        let (given, reach) = (self.camera.pose(), SearchReach { first, ..self.reach });
        let paired = |pose: &Pose, reach| self.pairs(pose, reach);
        let (mut aligned, mut n_steps) = align(given, reach, paired)?;
        let stiffness = self.stiffness(&aligned)?;
        if stiffness < self.config.min_stiffness {
            let hold = Hold { min_stiffness: self.config.min_stiffness, turn: None };
            (aligned, n_steps) = align_where_held(given, reach, &hold, paired)?;
        }
        self.fit(aligned, stiffness, n_steps)
    }

    /// Aligns the frame from the place of least misfit within its uncertainty: from the given pose alone, one
    /// face of a box may be taken for the next. `None` if no place is near enough.
    fn searched(&self) -> Result<Option<FrameFit>, Cancelled> {
        let thin = self.thinned();
        let given = self.camera.pose();
        let firm = Hold { min_stiffness: FIRM, turn: None };
        let (firm, _) = align_where_held(given, self.reach, &firm, |pose, reach| thin.pairs(pose, reach))?;
        let step = self.config.position_uncertainty / N_STEPS as f64;
        let mut places = thin.ranked(self.places(firm, step)?)?;
        places.truncate(N_LIKELY);
        let near = SearchReach { first: 1.5 * step.max(self.reach.last), ..self.reach };
        let loosely = LOOSELY * self.config.min_stiffness;
        let hold = Hold { min_stiffness: loosely, turn: Some((given.rotation(), TURN_ARM)) };
        let refine = |(_, place): &(f64, Pose)| {
            Ok(align_where_held(*place, near, &hold, |pose, reach| thin.pairs(pose, reach))?.0)
        };
        let refined = places.par_iter().map(refine).collect::<Result<Vec<_>, Cancelled>>()?;
        let Some(&(_, best)) = self.ranked(refined)?.first() else { return Ok(None) };
        let last = SearchReach { first: self.reach.last, ..self.reach };
        let hold = Hold { min_stiffness: loosely, turn: Some((best.rotation(), TURN_ARM)) };
        let (aligned, n_steps) = align_where_held(best, last, &hold, |pose, reach| self.pairs(pose, reach))?;
        self.fit(aligned, self.stiffness(&aligned)?, n_steps).map(Some)
    }

    /// Returns the frame with fewer points.
    fn thinned(&self) -> Self {
        let points = self.points.iter().step_by(EVERY).copied().collect();
        let known = self.known.iter().step_by(EVERY).copied().collect();
        Self { points, known, camera: self.camera.clone(), earlier: self.earlier.clone(), ..*self }
    }

    /// Returns a grid of poses around this one within the position's uncertainty, along the axes that hold
    /// the frame least.
    fn places(&self, around: Pose, step: f64) -> Result<Vec<Pose>, Cancelled> {
        let axes = loose_axes(&self.pairs(&around, self.reach.last)?);
        let side = 2 * N_STEPS + 1;
        let place = |number: usize| {
            let along = |(i, axis): (usize, &DVec3)| {
                *axis * step * ((number / side.pow(i as u32) % side) as f64 - N_STEPS as f64)
            };
            let shift = axes.iter().enumerate().map(along).sum();
            // Steps of a huge uncertainty may overflow.
            Pose::new(DQuat::IDENTITY, shift).ok().map(|motion| motion * around)
        };
        Ok((0..side.pow(axes.len() as u32)).filter_map(place).collect())
    }

    /// Returns the poses that are near enough with their misfits, the least first.
    fn ranked(&self, mut poses: Vec<Pose>) -> Result<Vec<(f64, Pose)>, Cancelled> {
        poses.retain(|pose| self.is_near(pose));
        let with_misfit = poses.par_iter().map(|pose| Ok((self.misfit(pose)?, *pose)));
        let mut ranked = with_misfit.collect::<Result<Vec<_>, Cancelled>>()?;
        ranked.sort_by(|(a, _), (b, _)| a.total_cmp(b));
        Ok(ranked)
    }

    /// Returns the fit of the frame in a pose with this stiffness.
    fn fit(&self, pose: Pose, stiffness: f64, n_iterations: usize) -> Result<FrameFit, Cancelled> {
        let (given, pairs) = (self.camera.pose(), self.pairs(&pose, self.reach.last)?);
        let motion = pose * given.inverse();
        let [residual_before, residual_after] =
            [motion.inverse(), Pose::IDENTITY].map(|to| residual(&pairs, &to));
        let is_held = stiffness >= self.config.min_stiffness;
        let n_contradictions = self.n_contradictions(&pose);
        let misfit = self.misfit_of(&pairs, n_contradictions);
        let registration = Registration {
            world_from_camera: pose,
            verdict: if is_held { Verdict::Aligned } else { Verdict::Sliding },
            residual_before,
            residual_after,
            overlap: pairs.len() as f64 / self.points.len().max(1) as f64,
            misfit: (misfit / self.points.len().max(1) as f64).sqrt(),
            moved: pose.translation().distance(given.translation()),
            turned: angle(&motion),
            stiffness,
            n_iterations,
        };
        Ok(FrameFit { registration, n_pairs: pairs.len(), n_contradictions, misfit })
    }

    /// Returns the first reason to reject the fit, if any.
    fn objection(&self, found: &FrameFit) -> Result<Option<Verdict>, Cancelled> {
        let (config, Registration { world_from_camera, overlap, .. }) = (self.config, found.registration);
        // A pose found from another image, elsewhere, is not a rival.
        let is_rival = config.given_poses != GivenPoses::Tracked;
        Ok(if overlap < config.min_overlap || found.n_pairs < LEAST_PAIRS {
            Some(Verdict::LittleOverlap)
        } else if !self.is_near(&world_from_camera) {
            Some(Verdict::TooFar)
        } else if is_rival && found.misfit >= self.misfit(&self.camera.pose())? {
            Some(Verdict::NoBetter)
        } else {
            None
        })
    }

    /// Whether this pose is within the uncertainty of the given pose.
    fn is_near(&self, pose: &Pose) -> bool {
        let given = self.camera.pose();
        pose.translation().distance(given.translation()) <= self.config.position_uncertainty
            && angle(&(*pose * given.inverse())) <= self.config.rotation_uncertainty
    }

    /// Returns the misfit of the frame in a pose, square metres: the sum of squared residuals of the points
    /// on the known surface, where each contradiction counts as a residual of the whole reach, and each other
    /// point as a quarter of that.
    fn misfit(&self, pose: &Pose) -> Result<f64, Cancelled> {
        Ok(self.misfit_of(&self.pairs(pose, self.reach.last)?, self.n_contradictions(pose)))
    }

    fn misfit_of(&self, pairs: &[Pair], n_contradictions: usize) -> f64 {
        let squares: f64 = pairs.iter().map(|pair| pair.residual().powi(2)).sum();
        let n_new = (self.points.len() - pairs.len()) as f64;
        squares + self.reach.last.powi(2) * (NEW * n_new + n_contradictions as f64)
    }

    /// Returns the number of points of the frame in a pose that an earlier camera looked through, plus the
    /// known points that the frame's camera looks through.
    fn n_contradictions(&self, pose: &Pose) -> usize {
        let margin = self.reach.last;
        let is_looked_through = |point: &&SurfacePoint| {
            let point = pose.transform_point(point.position);
            self.earlier.iter().any(|camera| camera.looks_through(point, margin))
        };
        let camera = self.camera.at(*pose);
        self.points.par_iter().filter(is_looked_through).count()
            + self.known.par_iter().filter(|point| camera.looks_through(**point, margin)).count()
    }

    /// Returns the points in a pose that lie on the known surface, within `reach` metres.
    fn pairs(&self, pose: &Pose, reach: f64) -> Result<Vec<Pair>, Cancelled> {
        pairs(&self.points, self.tree, pose, reach, self.cancel)
    }

    /// Returns how firmly the known surface holds the frame in a pose.
    fn stiffness(&self, pose: &Pose) -> Result<f64, Cancelled> {
        let pairs = self.pairs(pose, self.reach.last)?;
        Ok(NormalEquations::new(&pairs, self.reach.last).map_or(0.0, |equations| equations.stiffness()))
    }
}

/// Returns the axes that at most half of a surface faces.
fn loose_axes(pairs: &[Pair]) -> Vec<DVec3> {
    let mut squares = [[0.0; 3]; 3];
    for normal in pairs.iter().map(|pair| pair.normal.to_array()) {
        (0..3).for_each(|i| (0..3).for_each(|j| squares[i][j] += normal[i] * normal[j]));
    }
    let eigen = Eigen::of(squares);
    let axes = eigen.values.iter().zip(eigen.vectors);
    axes.filter(|(sum, _)| **sum <= MOST * pairs.len() as f64).map(|(_, axis)| DVec3::from(axis)).collect()
}

/// Returns the root mean square of the residuals after a motion, metres.
fn residual(pairs: &[Pair], motion: &Pose) -> f64 {
    let moved = |pair: &Pair| Pair { point: motion.transform_point(pair.point), ..*pair };
    let sum = pairs.iter().fold(0.0, |sum, pair| sum + moved(pair).residual().powi(2));
    (sum / pairs.len().max(1) as f64).sqrt()
}

/// The angle that a motion turns by, radians.
fn angle(motion: &Pose) -> f64 {
    2.0 * motion.rotation().xyz().length().atan2(motion.rotation().w.abs())
}
