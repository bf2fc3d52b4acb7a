use crate::accuracy::SurfaceDistance;
use crate::mesh::{TriangleMesh, sample_surface};
use glam::DVec3;
use nextview::geometry::Pose;
use nextview::registration::{Pair, PointPairs, SearchReach, SurfacePoint, align};
use nextview::surface::{CloudPoint, downsample};
use nextview::{Cancel, Error};
use rayon::prelude::*;
use std::convert::Infallible;

/// A part known by its CAD model, at any pose.
pub struct KnownPart {
    surface: SurfaceDistance,
    /// A few points of the model.
    samples: Vec<SurfacePoint>,
    pairs: PointPairs,
    /// Diagonal of the box around the model, metres.
    size: f64,
}

/// The pose of the part.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PartFit {
    /// Transform from the world to the CAD model.
    pub reference_from_world: Pose,
    /// Share of the points, 0..=1, near the model at this pose.
    pub share: f64,
    /// Share of the model, 0..=1, in places ruled out for the part.
    pub ruled_out_share: f64,
}

impl PartFit {
    /// Minimum [share](Self::share) of points near the model. Below it, the model is that of another part.
    pub const LEAST_SHARE: f64 = 0.6;
}

/// Spacing of the points whose pairs give the pose, as a share of the model's diagonal.
const SPACING: f64 = 0.05;

/// Number of model samples from which the points of the pairs are made.
const N_SAMPLES: usize = 30_000;

/// Number of poses tried, in addition to that of the scan's world.
const N_POSES: usize = 30;

/// Numbers of points used to compare poses and to refine the best one.
const N_POINTS: [usize; 2] = [600, 20_000];

/// First and final maximum pair distances, as shares of the diagonal: to compare poses, and to refine the
/// best one.
const REACH: [[f64; 2]; 2] = [[0.08, 0.01], [0.01, 0.003]];

/// A point is near the model within this share of the diagonal.
const NEAR: f64 = 0.01;

/// Weight of the ruled-out share of the model, relative to the share of points near it. Noise rules out
/// little: if two poses have the same points near the model, the one that is ruled out more is wrong.
const RULED_OUT: f64 = 2.0;

/// Minimum cosine between the normals of a point and of the model.
const AGREEMENT: f64 = 0.5;

impl KnownPart {
    /// Creates a part from a CAD model in metres whose triangles run counter-clockwise seen from outside.
    pub fn new(mesh: &TriangleMesh) -> Result<Self, Error> {
        let surface = SurfaceDistance::new(mesh);
        let with_normal = |position: DVec3| SurfacePoint { position, normal: surface.foot(position).1 };
        let samples: Vec<SurfacePoint> =
            sample_surface(mesh, N_SAMPLES, 0).into_par_iter().map(with_normal).collect();
        let size = mesh.bounds().size().length();
        let pairs = PointPairs::new(spaced(&samples, SPACING * size)?);
        Ok(Self { surface, samples: evenly(&samples, N_POINTS[0]), pairs, size })
    }

    /// Returns the model's surface, for the distance of any point.
    pub fn surface(&self) -> &SurfaceDistance {
        &self.surface
    }

    /// Returns the pose in which measured points with normals, in the world, fit the model best.
    /// `is_ruled_out` reports whether the part cannot be at a point of the world, which decides between poses
    /// of a part with similar sides. For a symmetric part, any of the equally right poses is returned.
    pub fn fit(
        &self,
        points: &[SurfacePoint],
        is_ruled_out: impl Fn(DVec3) -> bool + Sync,
        cancel: &Cancel,
    ) -> Result<PartFit, Error> {
        let found = self.pairs.poses(&spaced(points, SPACING * self.size)?, N_POSES, cancel)?;
        let few = evenly(points, N_POINTS[0]);
        let score = |fit: &PartFit| fit.share - RULED_OUT * fit.ruled_out_share;
        let mut best: Option<PartFit> = None;
        for start in [Pose::IDENTITY].into_iter().chain(found.iter().map(|voted| voted.known_from_shown)) {
            cancel.check()?;
            let fit = self.fit_from(start, &few, REACH[0], &is_ruled_out);
            // A later pose must be better by more than chance, so that a right initial pose is kept.
            if best.is_none_or(|best| score(&fit) > score(&best) + 0.01) {
                best = Some(fit);
            }
        }
        let best = best.map_or(Pose::IDENTITY, |best| best.reference_from_world);
        let many = evenly(points, N_POINTS[1]);
        Ok(self.fit_from(best, &many, REACH[1], &is_ruled_out))
    }

    fn fit_from(
        &self,
        start: Pose,
        points: &[SurfacePoint],
        reach: [f64; 2],
        is_ruled_out: impl Fn(DVec3) -> bool + Sync,
    ) -> PartFit {
        let pose = aligned(start, points, &self.surface, reach.map(|reach| reach * self.size));
        let world_from_reference = pose.inverse();
        let is_out =
            |sample: &&SurfacePoint| is_ruled_out(world_from_reference.transform_point(sample.position));
        let n_out = self.samples.par_iter().filter(is_out).count();
        PartFit {
            reference_from_world: pose,
            share: share_near(&pose, points, &self.surface, NEAR * self.size),
            ruled_out_share: n_out as f64 / self.samples.len().max(1) as f64,
        }
    }
}

/// The mean of the points in each cube whose normals agree.
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

/// A point at a pose and the nearest point of the model, if it is near and faces the same way.
fn pair(pose: &Pose, point: &SurfacePoint, surface: &SurfaceDistance, reach: f64) -> Option<Pair> {
    let (position, normal) = (pose.transform_point(point.position), pose.rotation() * point.normal);
    let (known, known_normal) = surface.foot_within(position, reach)?;
    (normal.dot(known_normal) >= AGREEMENT).then_some(Pair { point: position, known, normal: known_normal })
}

fn share_near(pose: &Pose, points: &[SurfacePoint], surface: &SurfaceDistance, near: f64) -> f64 {
    let n_near = points.par_iter().filter(|point| pair(pose, point, surface, near).is_some()).count();
    n_near as f64 / points.len().max(1) as f64
}
