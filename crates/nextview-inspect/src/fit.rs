use glam::DVec3;
use nextview::geometry::Pose;
use nextview::registration::{Pair, PointPairs, SearchReach, SurfacePoint, align};
use nextview::surface::{CloudPoint, downsample};
use nextview::{Cancel, Error};
use nextview_sim::accuracy::SurfaceDistance;
use nextview_sim::mesh::{TriangleMesh, sample_surface};
use rayon::prelude::*;
use std::convert::Infallible;

/// Where the part is.
pub(crate) struct Fit {
    /// Takes points of the scan's world to the CAD model.
    pub reference_from_world: Pose,
    /// Share of the points, 0..=1, that lie near the model there.
    pub share: f64,
}

/// Distance of the points whose pairs find the pose, as a share of the model's diagonal.
const SPACING: f64 = 0.05;

/// Samples of the model from which those points are made.
const N_SAMPLES: usize = 30_000;

/// Number of poses that are tried, besides that of the scan's world.
const N_POSES: usize = 30;

/// Number of points by which they are compared, and by which the best one is made exact.
const N_POINTS: [usize; 2] = [600, 20_000];

/// Farthest pairs at first and in the end, as shares of the diagonal: when poses are compared, and when the
/// best one is made exact.
const REACH: [[f64; 2]; 2] = [[0.08, 0.01], [0.01, 0.003]];

/// A point is near the model within this share of the diagonal.
const NEAR: f64 = 0.01;

/// Least cosine between the normals of a point and of the model.
const AGREEMENT: f64 = 0.5;

/// Finds the pose in which points (with normals) fit the model best.
pub(crate) fn fit(
    points: &[SurfacePoint],
    mesh: &TriangleMesh,
    surface: &SurfaceDistance,
    cancel: &Cancel,
) -> Result<Fit, Error> {
    let size = mesh.bounds().size().length();
    let known = PointPairs::new(spaced(&samples(mesh, surface), SPACING * size)?);
    let found = known.poses(&spaced(points, SPACING * size)?, N_POSES, cancel)?;
    let few = evenly(points, N_POINTS[0]);
    let mut best = Fit { reference_from_world: Pose::IDENTITY, share: -1.0 };
    let starts = found.iter().map(|voted| voted.known_from_shown);
    for start in [Pose::IDENTITY].into_iter().chain(starts) {
        cancel.check()?;
        let pose = aligned(start, &few, surface, REACH[0].map(|reach| reach * size));
        let share = share_near(&pose, &few, surface, NEAR * size);
        // A later one must be better by more than chance: what is right where it is stays there.
        if share > best.share + 0.01 {
            best = Fit { reference_from_world: pose, share };
        }
    }
    let many = evenly(points, N_POINTS[1]);
    let pose = aligned(best.reference_from_world, &many, surface, REACH[1].map(|reach| reach * size));
    Ok(Fit { reference_from_world: pose, share: share_near(&pose, &many, surface, NEAR * size) })
}

fn samples(mesh: &TriangleMesh, surface: &SurfaceDistance) -> Vec<SurfacePoint> {
    let with_normal = |position: DVec3| SurfacePoint { position, normal: surface.foot(position).1 };
    sample_surface(mesh, N_SAMPLES, 0).into_par_iter().map(with_normal).collect()
}

/// The mean of the points in each cube, where their normals agree.
fn spaced(points: &[SurfacePoint], spacing: f64) -> Result<Vec<SurfacePoint>, Error> {
    let point = |p: &SurfacePoint| CloudPoint { normal: Some(p.normal), ..p.position.into() };
    let thinned = downsample(points.iter().map(point), spacing)?;
    let with_normal = |p: CloudPoint| Some(SurfacePoint { position: p.position, normal: p.normal? });
    Ok(thinned.into_iter().filter_map(with_normal).collect())
}

fn evenly(points: &[SurfacePoint], n: usize) -> Vec<SurfacePoint> {
    points.iter().step_by(points.len().div_ceil(n).max(1)).copied().collect()
}

fn aligned(start: Pose, points: &[SurfacePoint], surface: &SurfaceDistance, reach: [f64; 2]) -> Pose {
    let pairs = |pose: &Pose, reach: f64| {
        let pairs: Vec<Option<Pair>> =
            points.par_iter().map(|point| pair(pose, point, surface, reach)).collect();
        Ok::<_, Infallible>(pairs.into_iter().flatten().collect())
    };
    let reach = SearchReach { first: reach[0], last: reach[1] };
    align(start, reach, pairs).unwrap_or_else(|never| match never {}).0
}

/// A point in a pose and the nearest one of the model, if it is near and faces the same way.
fn pair(pose: &Pose, point: &SurfacePoint, surface: &SurfaceDistance, reach: f64) -> Option<Pair> {
    let (position, normal) = (pose.transform_point(point.position), pose.rotation() * point.normal);
    let (known, known_normal) = surface.foot(position);
    let is_pair = position.distance(known) <= reach && normal.dot(known_normal) >= AGREEMENT;
    is_pair.then_some(Pair { point: position, known, normal: known_normal })
}

fn share_near(pose: &Pose, points: &[SurfacePoint], surface: &SurfaceDistance, near: f64) -> f64 {
    let n_near = points.par_iter().filter(|point| pair(pose, point, surface, near).is_some()).count();
    n_near as f64 / points.len().max(1) as f64
}
