use super::{ShownObject, rests};
use crate::geometry::{Plane, Pose};
use crate::registration::{Pair, PointPairs, SearchReach, SurfacePoint, align};
use crate::{Cancel, Cancelled};
use glam::{DQuat, DVec3};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

/// Spacing of the points whose pairs vote for poses, as a share of the diagonal of the known surface.
const SPACING: f64 = 0.06;

/// Number of poses tried, of those that pairs vote for.
const N_VOTED: usize = 30;

/// Number of turns about the vertical tried for each rest pose.
const N_TURNS: usize = 12;

/// Number of rest poses tried, those with the lowest centre of mass.
const N_RESTS: usize = 8;

/// Number of points by which poses are compared.
const N_POINTS: usize = 300;

/// Distance of the farthest pairs at first, as a share of the diagonal, and in the end, in voxels.
const REACH: (f64, f64) = (0.1, 1.5);

/// Number of poses compared by all points.
const N_BEST: usize = 12;

/// Maximum number of points that hold an object on a table: few compared to those that lie on its surface.
const N_CONTACTS: usize = 20;

/// Maximum distance of a point on the other surface from its tangent plane, in voxels.
const NEAR: f64 = 0.5;

/// Minimum angle by which the vertical of a turned object turns, radians: another side is down.
const LEAST_TILT: f64 = 0.35;

/// Minimum share of the new surface on the known one, and number of points.
const LEAST_OVERLAP: (f64, usize) = (0.2, 50);

/// Maximum share of points where the other placement rules the object out: noise.
const MOST_RULED_OUT: f64 = 0.03;

/// Minimum share of the points with a partner that lie on the other surface.
const LEAST_FITTING: f64 = 0.9;

/// Weight of a point that is ruled out, relative to one that lies on the other surface.
const RULED_OUT: f64 = 5.0;

/// Minimum score of a rival pose, relative to the best.
const RIVAL: f64 = 0.9;

/// Share of the points that two equal poses put on the same surface: a box or a plate looks alike in several
/// poses.
const SAME: f64 = 0.9;

/// How an object was turned from one placement to the next.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Turn {
    /// Transform from points of the earlier placement to where they are now.
    pub now_from_before: Pose,
    /// Share, 0..=1, of the surface shown now that was known before.
    pub overlap: f64,
    /// Root mean square distance of that surface from the tangent planes of the known surface, metres.
    #[serde(rename = "residual_m")]
    pub residual: f64,
}

/// Why the turn of an object could not be determined.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum TurnRefusal {
    /// Too little of the surface shown now was seen before.
    LittleOverlap,
    /// In every pose that fits, the object would be where one of the placements saw free space, or its
    /// surface would miss the other one.
    Contradicted,
    /// Two different poses fit nearly equally well.
    Ambiguous,
    /// The same side is down: the object lies as before, or was turned about the vertical.
    NotTurned,
}

/// A pose, and how well both surfaces fit in it.
#[derive(Clone, Copy, Debug)]
struct TurnFit {
    now_from_before: Pose,
    /// Share of the points shown now on the surface known before.
    overlap: f64,
    /// Number of those points.
    n_near: usize,
    residual: f64,
    /// Share of the points of both surfaces with a partner nearby that lie on the other surface.
    fitting: f64,
    /// Share of points where the other placement rules the object out, for the surface with more of them.
    ruled_out: f64,
    score: f64,
}

/// Finds how the object was turned, from the surface that both placements have shown and the space that they
/// have seen to be free. Refuses if the turn is uncertain.
///
/// Initial poses are those that pairs of oriented points vote for (Drost et al. 2010) and those in which the
/// object can rest on the table. For a symmetric object, any of the equally right poses is returned.
pub fn find_turn(
    before: &ShownObject,
    now: &ShownObject,
    cancel: &Cancel,
) -> Result<Result<Turn, TurnRefusal>, Cancelled> {
    let search = TurnSearch { before, now, size: diagonal(before.points()), cancel };
    if now.points().len() < LEAST_OVERLAP.1 || before.points().len() < LEAST_OVERLAP.1 {
        return Ok(Err(TurnRefusal::LittleOverlap));
    }
    let mut fits = search.fits()?;
    fits.sort_by(|a, b| b.score.total_cmp(&a.score)); // stable
    let overlaps = |fit: &&TurnFit| fit.overlap >= LEAST_OVERLAP.0 && fit.n_near >= LEAST_OVERLAP.1;
    let is_possible = |fit: &&TurnFit| fit.ruled_out <= MOST_RULED_OUT && fit.fitting >= LEAST_FITTING;
    let is_turned = |fit: &&TurnFit| search.tilt(&fit.now_from_before) >= LEAST_TILT;
    let mut possible = fits.iter().filter(overlaps).filter(is_possible).filter(is_turned);
    let Some(best) = possible.next() else {
        let of_all = fits.iter().find(overlaps);
        return Ok(Err(match of_all {
            None => TurnRefusal::LittleOverlap,
            Some(fit) if is_possible(&fit) => TurnRefusal::NotTurned,
            Some(_) => TurnRefusal::Contradicted,
        }));
    };
    let rivals = possible.take_while(|fit| fit.score >= RIVAL * best.score);
    for rival in rivals {
        if !search.is_same(&best.now_from_before, &rival.now_from_before)? {
            return Ok(Err(TurnRefusal::Ambiguous));
        }
    }
    let &TurnFit { now_from_before, overlap, residual, .. } = best;
    Ok(Ok(Turn { now_from_before, overlap, residual }))
}

impl Turn {
    /// Refines the turn by aligning the surface shown now.
    pub fn refined(
        &self,
        before: &ShownObject,
        now: &ShownObject,
        cancel: &Cancel,
    ) -> Result<Self, Cancelled> {
        let search = TurnSearch { before, now, size: diagonal(before.points()), cancel };
        let TurnFit { now_from_before, overlap, residual, .. } = search.exact(&self.now_from_before)?;
        Ok(Self { now_from_before, overlap, residual })
    }
}

struct TurnSearch<'a> {
    before: &'a ShownObject,
    now: &'a ShownObject,
    /// Diagonal of the box around the surface known before, metres.
    size: f64,
    cancel: &'a Cancel,
}

impl TurnSearch<'_> {
    /// The best poses, aligned by all points.
    fn fits(&self) -> Result<Vec<TurnFit>, Cancelled> {
        let few = evenly(self.now.points(), N_POINTS);
        let few_before = evenly(self.before.points(), N_POINTS);
        let rough = |start: &Pose| {
            let before_from_now = self.aligned(&start.inverse(), &few, self.coarse())?;
            self.fit(&before_from_now.inverse(), &few, &few_before)
        };
        let starts = self.starts()?;
        let mut fits: Vec<TurnFit> = starts.par_iter().map(rough).collect::<Result<_, _>>()?;
        fits.sort_by(|a, b| b.score.total_cmp(&a.score)); // stable
        let mut best: Vec<TurnFit> = Vec::new();
        for fit in fits {
            let is_known = best.iter().any(|known| self.is_one(&known.now_from_before, &fit.now_from_before));
            if !is_known && best.len() < N_BEST {
                best.push(fit);
            }
        }
        best.iter().map(|fit| self.exact(&fit.now_from_before)).collect()
    }

    /// Aligns a nearly correct pose by all points.
    fn exact(&self, now_from_before: &Pose) -> Result<TurnFit, Cancelled> {
        let reach = SearchReach { first: 2.0 * self.voxels(REACH.1), last: self.voxels(REACH.1) };
        let aligned = self.aligned(&now_from_before.inverse(), self.now.points(), reach)?;
        self.fit(&aligned.inverse(), self.now.points(), self.before.points())
    }

    fn aligned(&self, start: &Pose, points: &[SurfacePoint], reach: SearchReach) -> Result<Pose, Cancelled> {
        let pairs = |pose: &Pose, reach| {
            let on_surface = self.before.surface().pairs(points, pose, reach, self.cancel)?;
            Ok(on_surface.into_iter().chain(self.contacts(pose, points)).collect())
        };
        align(*start, reach, pairs).map(|(pose, _)| pose)
    }

    /// Pairs that hold the object on both tables: walls alone would let it slide up and down. The points of
    /// each placement that are lowest above the table of the other are pulled onto that table.
    fn contacts(&self, before_from_now: &Pose, points: &[SurfacePoint]) -> Vec<Pair> {
        let (of_before, of_now) = (self.before.table(), self.now.table());
        let moved = |point: &SurfacePoint| before_from_now.transform_point(point.position);
        let of_now_moved = of_now.moved(before_from_now);
        let on_now =
            lowest(self.before.points().iter().map(|point| point.position), of_now_moved, self.voxels(NEAR));
        let on_before = lowest(points.iter().map(moved), of_before, self.voxels(NEAR));
        let on_now = on_now.into_iter().map(|known| {
            let point = known - of_now_moved.height(known) * of_now_moved.normal();
            Pair { point, known, normal: of_now_moved.normal() }
        });
        let on_before = on_before.into_iter().map(|point| {
            let known = point - of_before.height(point) * of_before.normal();
            Pair { point, known, normal: of_before.normal() }
        });
        on_now.chain(on_before).collect()
    }

    fn fit(
        &self,
        now_from_before: &Pose,
        now: &[SurfacePoint],
        before: &[SurfacePoint],
    ) -> Result<TurnFit, Cancelled> {
        let reach = self.voxels(REACH.1);
        let before_from_now = now_from_before.inverse();
        let on_before =
            near(&self.before.surface().pairs(now, &before_from_now, reach, self.cancel)?, self.voxels(NEAR));
        let on_now =
            near(&self.now.surface().pairs(before, now_from_before, reach, self.cancel)?, self.voxels(NEAR));
        let fitting = (on_before.n + on_now.n) as f64 / (on_before.of + on_now.of).max(1) as f64;
        let share = |n: usize, of: usize| n as f64 / of.max(1) as f64;
        let ruled_out = |points: &[SurfacePoint], pose: &Pose, by: &ShownObject| {
            let n = points.iter().filter(|point| by.rules_out(pose.transform_point(point.position))).count();
            share(n, points.len())
        };
        let ruled_out =
            [ruled_out(now, &before_from_now, self.before), ruled_out(before, now_from_before, self.now)];
        let overlap = share(on_before.n, now.len());
        let score = overlap + share(on_now.n, before.len()) - RULED_OUT * (ruled_out[0] + ruled_out[1]);
        Ok(TurnFit {
            now_from_before: *now_from_before,
            overlap,
            n_near: on_before.n,
            residual: on_before.residual,
            fitting,
            ruled_out: ruled_out[0].max(ruled_out[1]),
            score,
        })
    }

    /// Initial poses, from the earlier placement to this one.
    fn starts(&self) -> Result<Vec<Pose>, Cancelled> {
        let spacing = SPACING * self.size;
        let known = PointPairs::new(spaced(self.before.points(), spacing));
        let voted = known.poses(&spaced(self.now.points(), spacing), N_VOTED, self.cancel)?;
        let voted = voted.iter().map(|voted| voted.known_from_shown.inverse());
        Ok(voted.chain(self.at_rest()).collect())
    }

    /// Poses in which the object, as far as it is known, rests on the table where it was found.
    fn at_rest(&self) -> Vec<Pose> {
        let positions: Vec<DVec3> = self.before.points().iter().map(|point| point.position).collect();
        // The underside, still unseen, is on the table.
        let feet = positions
            .iter()
            .map(|point| *point - self.before.table().height(*point) * self.before.table().normal());
        let outline: Vec<DVec3> = positions.iter().copied().chain(feet).collect();
        let middle = middle_of(&outline);
        let up = self.now.table().normal();
        let target = middle_of(&self.now.points().iter().map(|point| point.position).collect::<Vec<_>>());
        let target = target - self.now.table().height(target) * up;
        let poses = rests(&outline, middle).into_iter().take(N_RESTS).flat_map(|rest| {
            let onto = DQuat::from_rotation_arc(rest.down, -up);
            (0..N_TURNS).map(move |turn| {
                let rotation = DQuat::from_axis_angle(up, TAU * turn as f64 / N_TURNS as f64) * onto;
                Pose::new(rotation, target + rest.height * up - rotation * middle).ok()
            })
        });
        poses.flatten().collect()
    }

    /// Angle by which the vertical of the earlier placement turned, radians.
    fn tilt(&self, now_from_before: &Pose) -> f64 {
        (now_from_before.rotation() * self.before.table().normal()).angle_between(self.now.table().normal())
    }

    /// Whether both poses put the known surface at the same place.
    fn is_same(&self, a: &Pose, b: &Pose) -> Result<bool, Cancelled> {
        let points = self.before.points();
        let a_from_b = a.inverse() * *b;
        let reach = 2.0 * self.voxels(REACH.1);
        let pairs = self.before.surface().pairs(points, &a_from_b, reach, self.cancel)?;
        Ok(near(&pairs, self.voxels(2.0 * NEAR)).n as f64 >= SAME * points.len() as f64)
    }

    /// Whether two poses found from different starts are one.
    fn is_one(&self, a: &Pose, b: &Pose) -> bool {
        let turn = a.rotation().angle_between(b.rotation());
        let middle = self.before.snapshot().lattice().bounds(&self.before.snapshot().block()).center();
        let apart = a.transform_point(middle).distance(b.transform_point(middle));
        turn < 0.1 && apart < 0.05 * self.size
    }

    fn coarse(&self) -> SearchReach {
        let last = self.voxels(REACH.1);
        SearchReach { first: (REACH.0 * self.size).max(last), last }
    }

    fn voxels(&self, n: f64) -> f64 {
        n * self.before.snapshot().lattice().voxel_size()
    }
}

/// Points near the tangent planes of others.
struct Near {
    n: usize,
    /// Number of points with a partner, near its plane or not.
    of: usize,
    /// Root mean square, metres.
    residual: f64,
}

fn near(pairs: &[Pair], limit: f64) -> Near {
    let distances = pairs.iter().map(|pair| pair.normal.dot(pair.point - pair.known));
    let (n, sum) = distances.filter(|d| d.abs() <= limit).fold((0, 0.0), |(n, sum), d| (n + 1, sum + d * d));
    Near { n, of: pairs.len(), residual: (sum / n.max(1) as f64).sqrt() }
}

/// Returns some of the lowest points above a plane, up to this distance above the lowest one, metres.
fn lowest(points: impl Iterator<Item = DVec3>, plane: Plane, band: f64) -> Vec<DVec3> {
    let mut points: Vec<DVec3> = points.collect();
    let low = points.iter().map(|point| plane.height(*point)).fold(f64::INFINITY, f64::min);
    points.retain(|point| plane.height(*point) <= low + band);
    let step = points.len().div_ceil(N_CONTACTS).max(1);
    points.into_iter().step_by(step).collect()
}

/// Returns the first point of each cube with this edge, metres, and of each side that it faces.
fn spaced(points: &[SurfacePoint], edge: f64) -> Vec<SurfacePoint> {
    let mut taken = rustc_hash::FxHashSet::default();
    let cell = |point: &SurfacePoint| {
        let axis = point.normal.abs().max_position();
        ((point.position / edge).floor().as_i64vec3(), axis, point.normal[axis] < 0.0)
    };
    points.iter().filter(|point| taken.insert(cell(point))).copied().collect()
}

fn evenly(points: &[SurfacePoint], n: usize) -> Vec<SurfacePoint> {
    points.iter().step_by(points.len().div_ceil(n).max(1)).copied().collect()
}

fn middle_of(points: &[DVec3]) -> DVec3 {
    let low = points.iter().copied().fold(DVec3::INFINITY, DVec3::min);
    let high = points.iter().copied().fold(DVec3::NEG_INFINITY, DVec3::max);
    0.5 * (low + high)
}

fn diagonal(points: &[SurfacePoint]) -> f64 {
    let positions = || points.iter().map(|point| point.position);
    let low = positions().fold(DVec3::INFINITY, DVec3::min);
    low.distance(positions().fold(DVec3::NEG_INFINITY, DVec3::max))
}
