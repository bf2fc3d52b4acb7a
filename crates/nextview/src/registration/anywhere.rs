//! Finds the pose of a surface without a prior, from pairs of oriented points (Drost et al. 2010).

use super::surface_points::SurfacePoint;
use crate::geometry::Pose;
use crate::{Cancel, Cancelled};
use glam::{DQuat, DVec3};
use rayon::prelude::*;
use rustc_hash::FxHashMap;
use std::f64::consts::{PI, TAU};

/// Quantisation step of a pair's distance, as a share of the largest distance.
const DISTANCE_STEP: f64 = 0.05;

/// Number of angle steps in half a turn: 12 degrees each.
const ANGLE_STEPS: f64 = 15.0;

/// Number of steps of the turn around a normal.
const TURN_STEPS: usize = 30;

/// Stride of the points of the shown surface that vote as first points of pairs.
const STRIDE: usize = 4;

/// Two poses are the same if their rotations differ by less than this, radians, and the images of the points'
/// middle by less than this share of the largest distance.
const ONE_POSE: (f64, f64) = (0.35, 0.1);

/// Distance and three angles of a pair, quantised.
type Key = [u8; 4];

/// A surface in which others are located: all pairs of its points by distance and angles.
pub struct PointPairs {
    points: Vec<SurfacePoint>,
    /// Largest distance of two points, metres.
    size: f64,
    /// The first point of each pair, and the turn of the second one around the first one's normal.
    pairs: FxHashMap<Key, Vec<(u32, f32)>>,
}

/// A pose that pairs voted for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VotedPose {
    /// Transforms points of the shown surface to the known one.
    pub known_from_shown: Pose,
    /// Number of pairs that voted for it.
    pub votes: u32,
}

impl PointPairs {
    /// Returns the pairs of evenly spaced points on a surface: a few hundred to a thousand points, since all
    /// pairs are stored.
    pub fn new(points: Vec<SurfacePoint>) -> Self {
        let size = diagonal(&points);
        let mut pairs: FxHashMap<Key, Vec<(u32, f32)>> = FxHashMap::default();
        for (i, first) in points.iter().enumerate() {
            let local = onto_axis(first);
            for second in points.iter().enumerate().filter(|(j, _)| *j != i).map(|(_, second)| second) {
                let turn = turn(local.transform_point(second.position));
                pairs.entry(key(first, second, size)).or_default().push((i as u32, turn as f32));
            }
        }
        Self { points, size, pairs }
    }

    /// Returns the likely poses of a shown surface, with points spaced as in this one, by decreasing votes,
    /// up to a maximum number. They are rough; [`align`](super::align) refines the correct one.
    ///
    /// Both surfaces may be partial. A symmetric one has several equally correct poses.
    pub fn poses(
        &self,
        shown: &[SurfacePoint],
        n_poses: usize,
        cancel: &Cancel,
    ) -> Result<Vec<VotedPose>, Cancelled> {
        let firsts: Vec<usize> = (0..shown.len()).step_by(STRIDE).collect();
        let voted: Vec<Option<VotedPose>> = firsts
            .par_iter()
            .map(|first| cancel.check().map(|()| self.vote(shown, *first)))
            .collect::<Result<_, _>>()?;
        let middle = shown.iter().map(|point| point.position).sum::<DVec3>() / shown.len().max(1) as f64;
        let mut voted: Vec<VotedPose> = voted.into_iter().flatten().collect();
        voted.sort_by_key(|pose| std::cmp::Reverse(pose.votes)); // stable
        let mut poses: Vec<VotedPose> = Vec::new();
        for pose in voted {
            match poses.iter_mut().find(|known| self.is_one(known, &pose, middle)) {
                Some(known) => known.votes += pose.votes,
                None => poses.push(pose),
            }
        }
        poses.sort_by_key(|pose| std::cmp::Reverse(pose.votes));
        poses.truncate(n_poses);
        Ok(poses)
    }

    /// Returns the pose with most votes among pairs with this first point.
    fn vote(&self, shown: &[SurfacePoint], first: usize) -> Option<VotedPose> {
        let local = onto_axis(&shown[first]);
        let mut votes = vec![0_u32; self.points.len() * TURN_STEPS];
        for (j, second) in shown.iter().enumerate() {
            if j == first || second.position.distance(shown[first].position) > self.size {
                continue;
            }
            let Some(pairs) = self.pairs.get(&key(&shown[first], second, self.size)) else { continue };
            let shown_turn = turn(local.transform_point(second.position));
            for (known, known_turn) in pairs {
                let turn = (f64::from(*known_turn) - shown_turn).rem_euclid(TAU) / TAU;
                let step = ((turn * TURN_STEPS as f64) as usize).min(TURN_STEPS - 1);
                votes[*known as usize * TURN_STEPS + step] += 1;
            }
        }
        let (best, most) = votes.iter().enumerate().max_by_key(|(i, n)| (**n, std::cmp::Reverse(*i)))?;
        let turn = (best % TURN_STEPS) as f64 + 0.5;
        let turn = DQuat::from_rotation_x(TAU * turn / TURN_STEPS as f64);
        let turned = Pose::new(turn, DVec3::ZERO).ok()?;
        let known_from_axis = onto_axis(&self.points[best / TURN_STEPS]).inverse();
        (*most > 0).then_some(VotedPose { known_from_shown: known_from_axis * turned * local, votes: *most })
    }

    fn is_one(&self, a: &VotedPose, b: &VotedPose, middle: DVec3) -> bool {
        let (a, b) = (a.known_from_shown, b.known_from_shown);
        let apart = a.transform_point(middle).distance(b.transform_point(middle));
        a.rotation().angle_between(b.rotation()) < ONE_POSE.0 && apart < ONE_POSE.1 * self.size
    }
}

/// The diagonal of the box around the points.
fn diagonal(points: &[SurfacePoint]) -> f64 {
    let low = points.iter().fold(DVec3::INFINITY, |low, point| low.min(point.position));
    let high = points.iter().fold(DVec3::NEG_INFINITY, |high, point| high.max(point.position));
    if points.is_empty() { 0.0 } else { low.distance(high) }
}

fn key(first: &SurfacePoint, second: &SurfacePoint, size: f64) -> Key {
    let apart = second.position - first.position;
    let length = apart.length();
    let along = apart / length.max(f64::MIN_POSITIVE);
    let angle = |a: DVec3, b: DVec3| (a.dot(b).clamp(-1.0, 1.0).acos() / PI * ANGLE_STEPS) as u8;
    let distance = length / (DISTANCE_STEP * size);
    [
        distance as u8,
        angle(first.normal, along),
        angle(second.normal, along),
        angle(first.normal, second.normal),
    ]
}

/// Returns the pose that moves the point to the origin and turns its normal onto the x axis.
fn onto_axis(point: &SurfacePoint) -> Pose {
    let rotation = DQuat::from_rotation_arc(point.normal, DVec3::X).normalize();
    Pose::new(rotation, -(rotation * point.position)).unwrap_or(Pose::IDENTITY)
}

/// The angle around the x axis.
fn turn(position: DVec3) -> f64 {
    position.z.atan2(position.y)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::random::Random;

    /// Points of three stacked boxes of different sizes: no symmetry.
    fn object() -> Vec<SurfacePoint> {
        let boxes = [
            ([0.0, 0.0, 0.0], [0.1, 0.06, 0.04]),
            ([0.02, 0.01, 0.04], [0.03, 0.02, 0.05]),
            ([0.07, 0.03, 0.04], [0.02, 0.03, 0.02]),
        ];
        let mut points = Vec::new();
        for (corner, size) in boxes.map(|(corner, size)| (DVec3::from(corner), DVec3::from(size))) {
            for axis in 0..3 {
                let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
                for (side, sign) in [(0.0, -1.0), (1.0, 1.0)] {
                    let (n_u, n_v) = ((size[u] / 0.008).ceil() as usize, (size[v] / 0.008).ceil() as usize);
                    for (i, j) in (0..n_u).flat_map(|i| (0..n_v).map(move |j| (i, j))) {
                        let mut position = corner;
                        position[axis] += side * size[axis];
                        position[u] += (i as f64 + 0.5) / n_u as f64 * size[u];
                        position[v] += (j as f64 + 0.5) / n_v as f64 * size[v];
                        let mut normal = DVec3::ZERO;
                        normal[axis] = sign;
                        points.push(SurfacePoint { position, normal });
                    }
                }
            }
        }
        points
    }

    #[test]
    fn a_part_is_found_from_anywhere() {
        let known = PointPairs::new(object());
        let mut random = Random::new(5, 0);
        for _ in 0..8 {
            let axis = random.in_cube().normalize();
            let rotation = DQuat::from_axis_angle(axis, random.range(0.0, PI));
            let shown_from_known = Pose::new(rotation, 0.5 * random.in_cube()).unwrap();
            // Half of it, seen from a side, with noise.
            let side = random.in_cube().normalize();
            let part = object().into_iter().filter(|point| point.normal.dot(side) > -0.3);
            let shown: Vec<SurfacePoint> = part
                .map(|point| {
                    let noisy = point.moved(&shown_from_known);
                    SurfacePoint { position: noisy.position + 0.0005 * random.in_cube(), ..noisy }
                })
                .collect();
            let poses = known.poses(&shown, 10, &Cancel::default()).unwrap();
            let off = |pose: &VotedPose| {
                let rest = pose.known_from_shown * shown_from_known;
                (rest.rotation().angle_between(DQuat::IDENTITY), rest.translation().length())
            };
            assert!(poses.iter().any(|pose| off(pose).0 < 0.3 && off(pose).1 < 0.03), "{:?}", off(&poses[0]));
            assert!(poses.is_sorted_by(|a, b| a.votes >= b.votes));
        }
    }

    #[test]
    fn nothing_is_found_in_nothing() {
        assert_eq!(PointPairs::new(Vec::new()).poses(&object(), 5, &Cancel::default()), Ok(Vec::new()));
        assert_eq!(PointPairs::new(object()).poses(&[], 5, &Cancel::default()), Ok(Vec::new()));
        let cancel = Cancel::default();
        cancel.cancel();
        assert_eq!(PointPairs::new(object()).poses(&object(), 5, &cancel), Err(Cancelled));
    }
}
