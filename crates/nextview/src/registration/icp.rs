use super::normal_equations::NormalEquations;
use super::pair::Pair;
use super::point_tree::PointTree;
use super::surface_points::SurfacePoint;
use crate::geometry::Pose;
use crate::{Cancel, Cancelled};
use glam::DQuat;
use rayon::prelude::*;

/// The weight of a pair falls to a quarter where the residual is this share of the reach, as in KISS-ICP
/// (Vizzo et al. 2023).
const SCALE: f64 = 1.0 / 3.0;

/// The reach after a step, as a share of the reach before.
const NARROWING: f64 = 0.7;

/// Maximum number of steps: by then, only a few points still alternate between partners.
pub const MAX_STEPS: usize = 30;

/// Iteration ends when a step moves points by less than this share of the reach.
const SMALL_STEP: f64 = 5e-3;

/// Search distance for correspondences, metres. It shrinks with each step.
#[derive(Clone, Copy, Debug)]
pub struct SearchReach {
    /// In the first step.
    pub first: f64,
    /// In the last steps.
    pub last: f64,
}

/// Aligns points to a surface from a roughly correct pose. Returns the pose and the number of steps, at most
/// [`MAX_STEPS`].
///
/// `pairs` returns the point pairs for a pose: the points within a distance (metres) of the surface, in a
/// fixed order.
///
/// Iterative closest points (Besl & McKay 1992) with the distance from the tangent plane (Chen & Medioni
/// 1992). Far points weigh little (Geman & McClure 1987). Fails if `pairs` fails.
pub fn align<E>(
    given: Pose,
    reach: SearchReach,
    pairs: impl Fn(&Pose, f64) -> Result<Vec<Pair>, E>,
) -> Result<(Pose, usize), E> {
    align_where_held(given, reach, &Hold { min_stiffness: 0.0, turn: None }, pairs)
}

/// Constraints on motions that the surface does not determine.
#[derive(Clone, Copy, Debug)]
pub(super) struct Hold {
    /// Directions with less stiffness than this keep the given pose (solution remapping, Zhang, Kaess & Singh
    /// 2016).
    pub min_stiffness: f64,
    /// A rotation to stay near: a turn from it counts like a residual of the turn, radians, times this
    /// length, metres.
    pub turn: Option<(DQuat, f64)>,
}

/// As [`align`], with constraints.
pub(super) fn align_where_held<E>(
    given: Pose,
    reach: SearchReach,
    hold: &Hold,
    pairs: impl Fn(&Pose, f64) -> Result<Vec<Pair>, E>,
) -> Result<(Pose, usize), E> {
    let (mut pose, mut distance) = (given, reach.first);
    for n_steps in 1..=MAX_STEPS {
        let Some(equations) = NormalEquations::new(&pairs(&pose, distance)?, SCALE * distance) else {
            return Ok((pose, n_steps));
        };
        let equations = match hold.turn {
            Some((rotation, arm)) => {
                let turn = pose.rotation() * rotation.inverse();
                // A rotation has two quaternions; this is the shorter one.
                let turn = if turn.w < 0.0 { -turn } else { turn };
                equations.with_turn_held(turn.to_scaled_axis(), arm)
            }
            None => equations,
        };
        let (motion, size) = equations.step(hold.min_stiffness);
        pose = motion * pose;
        if distance <= reach.last && size < SMALL_STEP * reach.last {
            return Ok((pose, n_steps));
        }
        distance = (NARROWING * distance).max(reach.last);
    }
    Ok((pose, MAX_STEPS))
}

/// Returns the points with their nearest known ones that face the same way within `reach` metres, in the
/// order of the points.
pub(super) fn pairs(
    points: &[SurfacePoint],
    known: &PointTree,
    pose: &Pose,
    reach: f64,
    cancel: &Cancel,
) -> Result<Vec<Pair>, Cancelled> {
    let pair = |point: &SurfacePoint| {
        let point = point.moved(pose);
        let nearest = known.nearest(&point, reach)?;
        // On a curved surface, the line between two points is perpendicular to the mean of their normals, not
        // to either normal (Rusinkiewicz 2019).
        let normal = (point.normal + nearest.normal).normalize();
        Some(Pair { point: point.position, known: nearest.position, normal })
    };
    let found = points.par_iter().map(|point| cancel.check().map(|()| pair(point)));
    Ok(found.collect::<Result<Vec<_>, _>>()?.into_iter().flatten().collect())
}
