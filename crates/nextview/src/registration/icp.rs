use super::normal_equations::NormalEquations;
use super::pair::Pair;
use super::point_tree::PointTree;
use super::surface_points::SurfacePoint;
use crate::geometry::Pose;
use crate::{Cancel, Cancelled};
use rayon::prelude::*;

/// Minimum cosine between the normals of a pair: 45 degrees. The other side of a thin wall does not match.
const LEAST_AGREEMENT: f64 = 0.7;

/// The weight of a pair falls to a quarter where the residual is this share of the reach, as in KISS-ICP
/// (Vizzo et al. 2023).
const SCALE: f64 = 1.0 / 3.0;

/// The reach after a step, as a share of that before.
const NARROWING: f64 = 0.7;

/// Maximum number of steps: by then at most a few points still switch back and forth between partners.
const MAX_STEPS: usize = 30;

/// A step that moves points by less than this share of the reach is the last.
const SMALL_STEP: f64 = 5e-3;

/// Search distance for correspondences, metres.
#[derive(Clone, Copy, Debug)]
pub(super) struct Reach {
    /// At first.
    pub first: f64,
    /// In the end.
    pub last: f64,
}

/// Aligns points (in the camera frame) to the known surface from a given pose that is roughly right; returns
/// the pose and the number of steps.
///
/// Iterative closest points (Besl & McKay 1992) with the distance from the tangent plane (Chen & Medioni
/// 1992).
pub(super) fn align(
    points: &[SurfacePoint],
    known: &PointTree,
    given: Pose,
    reach: Reach,
    cancel: &Cancel,
) -> Result<(Pose, usize), Cancelled> {
    let (mut pose, mut distance) = (given, reach.first);
    for n_steps in 1..=MAX_STEPS {
        let pairs = pairs(points, known, &pose, distance, cancel)?;
        let Some(equations) = NormalEquations::new(&pairs, SCALE * distance) else {
            return Ok((pose, n_steps));
        };
        let (motion, size) = equations.step();
        pose = motion * pose;
        if distance <= reach.last && size < SMALL_STEP * reach.last {
            return Ok((pose, n_steps));
        }
        distance = (NARROWING * distance).max(reach.last);
    }
    Ok((pose, MAX_STEPS))
}

/// The points with the nearest known ones that face the same way and are within `reach` metres, in the order
/// of the points.
pub(super) fn pairs(
    points: &[SurfacePoint],
    known: &PointTree,
    pose: &Pose,
    reach: f64,
    cancel: &Cancel,
) -> Result<Vec<Pair>, Cancelled> {
    let pair = |point: &SurfacePoint| {
        let SurfacePoint { position, normal } = point.moved(pose);
        let nearest = known.nearest(position, reach, |known| known.normal.dot(normal) >= LEAST_AGREEMENT)?;
        let normal = (normal + nearest.normal).normalize();
        Some(Pair { point: position, known: nearest.position, normal })
    };
    let found = points.par_iter().map(|point| cancel.check().map(|()| pair(point)));
    Ok(found.collect::<Result<Vec<_>, _>>()?.into_iter().flatten().collect())
}
