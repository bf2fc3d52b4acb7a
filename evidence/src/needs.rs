//! The needs of scan purposes: measures of a scan's frames on the true surface.

use glam::DVec3;
use nextview::Cancel;
use nextview::geometry::random::Random;
use nextview::geometry::{Aabb, Pose};
use nextview::sensor::{Frame, SurfaceNoise};
use nextview::surface::MeasuredCells;
use nextview::view::ViewSpace;
use nextview_sim::camera::SimulatedCamera;
use nextview_sim::mesh::TriangleMesh;
use rayon::prelude::*;
use std::error::Error;
use std::ops::Range;

/// Number of samples of the true surface.
const N_SAMPLES: usize = 10_000;

/// A sample is seen if its pixel measures the object within this distance, metres.
const SEEN: f64 = 0.002;

/// Angles between directions in which features of a surface are matched between pictures: large enough to
/// give depth, and small enough to look alike. Degrees.
const BASELINE: Range<f64> = 5.0..45.0;

/// Maximum angle of a counted look from the normal, and minimum angle from earlier looks. Degrees.
const GOOD_LOOK: f64 = 60.0;
const APART: f64 = 10.0;

/// Step between the candidates that determine the visible surface.
const CANDIDATES: usize = 4;

/// Number of looks wanted, and of pictures for matching features.
const N_LOOKS: usize = 3;

/// The true object for the evaluation of purposes.
pub struct TrueObject<'a> {
    camera: &'a SimulatedCamera,
    /// Surface samples seen by at least one of the checked candidates (every fourth).
    samples: Vec<SurfaceSample>,
    /// Unit vectors from the middle of the object to the candidates.
    directions: Vec<DVec3>,
    middle: DVec3,
}

/// A point of the surface with its normal, on either side.
#[derive(Clone, Copy)]
struct SurfaceSample {
    point: DVec3,
    normal: DVec3,
}

/// The measures of one scan for all purposes. Shares are of the surface that any candidate sees.
#[derive(Clone, Copy, Debug, Default)]
pub struct Needs {
    /// Share seen.
    pub surface: f64,
    /// Angle between a candidate's direction and the nearest one taken: the largest and the mean, degrees.
    pub angles_deg: [f64; 2],
    /// Share of the surface seen by a view that an earlier one saw: minimum and mean over all but the first.
    pub overlap: [f64; 2],
    /// Share seen in three pictures at least 5 degrees apart, two pairs of them at most 45.
    pub matchable: f64,
    /// Share with three looks at least 10 degrees apart and at most 60 from the normal.
    pub looks: f64,
    /// Share with an expected error within the goal.
    pub at_goal: f64,
}

impl Needs {
    /// Returns the measures in the order of their fields, for means and differences.
    pub fn values(&self) -> [f64; 8] {
        let Self { surface, angles_deg: [largest, mean], overlap: [least, usual], matchable, looks, at_goal } =
            *self;
        [surface, largest, mean, least, usual, matchable, looks, at_goal]
    }
}

impl<'a> TrueObject<'a> {
    /// Puts the object in front of a camera, among candidates around it.
    pub fn new(
        camera: &'a SimulatedCamera,
        middle: DVec3,
        candidates: &ViewSpace,
    ) -> Result<Self, Box<dyn Error>> {
        let samples = samples(camera.mesh());
        let few: Vec<&Pose> = candidates.poses().iter().step_by(CANDIDATES).collect();
        let seen = few.into_par_iter().map(|pose| seen_from(camera, &samples, pose));
        let seen = seen.collect::<Result<Vec<_>, _>>()?;
        let is_reachable = |i: &usize| seen.iter().any(|seen| seen[*i]);
        let samples = (0..samples.len()).filter(is_reachable).map(|i| samples[i]).collect();
        let directions =
            candidates.poses().iter().map(|pose| (pose.translation() - middle).normalize()).collect();
        Ok(Self { camera, samples, directions, middle })
    }

    /// Evaluates these frames by a camera with this error and exact poses; `goal` is a standard deviation,
    /// metres, in cells of this size.
    pub fn needs(
        &self,
        frames: &[Frame],
        bounds: Aabb,
        (cell, error, goal): (f64, SurfaceNoise, f64),
    ) -> Result<Needs, Box<dyn Error>> {
        let poses: Vec<Pose> = frames.iter().map(|frame| frame.world_from_camera()).collect();
        let seen = poses.par_iter().map(|pose| seen_from(self.camera, &self.samples, pose));
        let seen = seen.collect::<Result<Vec<_>, _>>()?;
        let mut cells = MeasuredCells::new(cell, error)?;
        frames.iter().try_for_each(|frame| cells.add(frame, bounds, &Cancel::default()))?;
        let share = |is: &(dyn Fn(usize) -> bool + Sync)| {
            let n = (0..self.samples.len()).into_par_iter().filter(|i| is(*i)).count();
            n as f64 / self.samples.len() as f64
        };
        let of_sample = |i: usize| -> Vec<DVec3> {
            let views = poses.iter().zip(&seen).filter(|(_, seen)| seen[i]);
            views.map(|(pose, _)| (pose.translation() - self.samples[i].point).normalize()).collect()
        };
        Ok(Needs {
            surface: share(&|i| seen.iter().any(|seen| seen[i])),
            angles_deg: self.angles(&poses),
            overlap: overlap(&seen),
            matchable: share(&|i| is_matchable(&of_sample(i))),
            looks: share(&|i| n_looks(&of_sample(i), self.samples[i].normal) >= N_LOOKS),
            at_goal: share(&|i| cells.error_at(self.samples[i].point).is_some_and(|error| error <= goal)),
        })
    }

    fn angles(&self, poses: &[Pose]) -> [f64; 2] {
        let taken: Vec<DVec3> =
            poses.iter().map(|pose| (pose.translation() - self.middle).normalize()).collect();
        let nearest =
            |direction: &DVec3| taken.iter().map(|taken| degrees(*taken, *direction)).fold(180.0, f64::min);
        let angles: Vec<f64> = self.directions.iter().map(nearest).collect();
        [angles.iter().copied().fold(0.0, f64::max), angles.iter().sum::<f64>() / angles.len() as f64]
    }
}

/// Points of the surface, uniform by area.
fn samples(mesh: &TriangleMesh) -> Vec<SurfaceSample> {
    let cross = |i: usize| {
        let [a, b, c] = mesh.corners(i);
        (b - a).cross(c - a)
    };
    let mut sum = 0.0;
    let sums: Vec<f64> = (0..mesh.triangles().len())
        .map(|i| {
            sum += cross(i).length();
            sum
        })
        .collect();
    let mut random = Random::new(0, 0);
    let sample = |_| {
        let drawn = random.unit() * sum;
        let triangle = sums.partition_point(|sum| *sum <= drawn).min(sums.len() - 1);
        let ([a, b, c], row, along) = (mesh.corners(triangle), random.unit().sqrt(), random.unit());
        let point = a + row * (1.0 - along) * (b - a) + row * along * (c - a);
        SurfaceSample { point, normal: cross(triangle).normalize_or_zero() }
    };
    (0..N_SAMPLES).map(sample).collect()
}

/// By sample, whether a picture from this pose truly measures it.
fn seen_from(
    camera: &SimulatedCamera,
    samples: &[SurfaceSample],
    pose: &Pose,
) -> Result<Vec<bool>, nextview::Error> {
    let look = camera.look(pose)?;
    Ok(samples.iter().map(|sample| look.shows(sample.point, SEEN)).collect())
}

/// The share of the surface seen by each view but the first that an earlier one saw: the minimum and the
/// mean.
fn overlap(seen: &[Vec<bool>]) -> [f64; 2] {
    let Some((first, others)) = seen.split_first() else { return [0.0; 2] };
    let (mut known, mut shares) = (first.clone(), Vec::new());
    for view in others {
        let n_seen = view.iter().filter(|seen| **seen).count();
        let n_known = view.iter().zip(&known).filter(|(seen, known)| **seen && **known).count();
        shares.push(n_known as f64 / n_seen.max(1) as f64);
        known.iter_mut().zip(view).for_each(|(known, seen)| *known |= seen);
    }
    [shares.iter().copied().fold(1.0, f64::min), shares.iter().sum::<f64>() / shares.len().max(1) as f64]
}

/// Whether three of the directions are far enough apart, and two pairs of them close enough.
fn is_matchable(directions: &[DVec3]) -> bool {
    let n = directions.len();
    let angle = |i: usize, j: usize| degrees(directions[i], directions[j]);
    let is_match = |i: usize, j: usize, k: usize| {
        let angles = [angle(i, j), angle(j, k), angle(i, k)];
        let n_near = angles.iter().filter(|angle| **angle <= BASELINE.end).count();
        n_near >= 2 && angles.iter().all(|angle| *angle >= BASELINE.start)
    };
    (0..n).any(|i| (i + 1..n).any(|j| (j + 1..n).any(|k| is_match(i, j, k))))
}

/// Number of directions that see a surface well, each distinct from the earlier ones.
fn n_looks(directions: &[DVec3], normal: DVec3) -> usize {
    let mut looks: Vec<DVec3> = Vec::new();
    for &direction in directions {
        let is_steep = direction.dot(normal).abs() >= GOOD_LOOK.to_radians().cos();
        if is_steep && looks.iter().all(|look| degrees(*look, direction) >= APART) {
            looks.push(direction);
        }
    }
    looks.len()
}

fn degrees(a: DVec3, b: DVec3) -> f64 {
    a.dot(b).clamp(-1.0, 1.0).acos().to_degrees()
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DQuat;

    fn at(degrees: f64) -> DVec3 {
        DQuat::from_rotation_y(degrees.to_radians()) * DVec3::Z
    }

    fn around(degrees: &[f64]) -> Vec<DVec3> {
        degrees.iter().copied().map(at).collect()
    }

    #[test]
    fn three_pictures_are_matched_if_they_are_neither_too_near_nor_too_far() {
        assert!(is_matchable(&around(&[0.0, 30.0, 60.0])));
        assert!(!is_matchable(&around(&[0.0, 30.0])));
        assert!(!is_matchable(&around(&[0.0, 2.0, 30.0])));
        assert!(!is_matchable(&around(&[0.0, 30.0, 90.0])));
        assert!(is_matchable(&around(&[0.0, 90.0, 2.0, 30.0, 120.0, 60.0])));
    }

    #[test]
    fn looks_are_steep_and_apart() {
        let n = |degrees: &[f64]| n_looks(&around(degrees), DVec3::Z);
        assert_eq!([n(&[]), n(&[0.0, 5.0]), n(&[0.0, 12.0, 80.0]), n(&[-55.0, 0.0, 55.0])], [0, 1, 2, 3]);
    }

    #[test]
    fn overlap_is_with_all_views_before() {
        let seen =
            [vec![true, true, false, false], vec![false, true, true, false], vec![true, false, true, false]];
        assert_eq!(overlap(&seen), [0.5, 0.75]);
        assert_eq!(overlap(&seen[..1]), [1.0, 0.0]);
    }
}
