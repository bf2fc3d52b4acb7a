use super::{Reachability, csv};
use crate::Error;
use crate::geometry::{Pose, check_position};
use crate::sensor::DepthRange;
use glam::DVec3;
use std::io::{Read, Write};

/// The view candidates: an immutable list of camera poses (`world_from_camera`), numbered from 0. Some may be
/// out of reach; they keep their numbers.
#[derive(Clone, Debug, PartialEq)]
pub struct ViewSpace {
    poses: Vec<Pose>,
    within_reach: Vec<bool>,
}

impl ViewSpace {
    /// Creates a view space of at least one pose.
    pub fn new(poses: Vec<Pose>) -> Result<Self, Error> {
        if poses.is_empty() {
            return Err(Error::invalid("view space", "empty", "at least one view candidate"));
        }
        Ok(Self { within_reach: vec![true; poses.len()], poses })
    }

    /// Reads candidates from CSV text: one row per candidate, `x_m, y_m, z_m` for a camera that looks at
    /// `target`, or `x_m, y_m, z_m, qx, qy, qz, qw` for a whole pose (`world_from_camera`, Hamilton
    /// quaternion). A header with these names may come first; then other columns are ignored. Empty lines and
    /// lines that start with `#` are skipped. Errors name the line.
    pub fn read_csv(reader: impl Read, target: DVec3) -> Result<Self, Error> {
        Self::new(csv::read(reader, target)?)
    }

    /// Writes the candidates as CSV that [`read_csv`](Self::read_csv) reads back to the same bits.
    pub fn write_csv(&self, writer: impl Write) -> Result<(), Error> {
        csv::write(writer, &self.poses)
    }

    /// Moves candidates made for an object of size 1 at the origin to an object elsewhere: in the same
    /// directions from `center`, `size` times as far away (metres).
    ///
    /// Fails if a position would be beyond [`Pose::REACH`].
    pub fn around(&self, center: DVec3, size: f64) -> Result<Self, Error> {
        let moved = |pose: &Pose| {
            let position = center + pose.translation() * size;
            check_position("position of a view", position).map(|()| pose.with_translation(position))
        };
        let poses = self.poses.iter().map(moved).collect::<Result<_, _>>()?;
        Ok(Self { poses, within_reach: self.within_reach.clone() })
    }

    /// As [`around`](Self::around), for an object known to be within [`Pose::REACH`]: candidates that would
    /// be beyond it are out of reach and stay where they are.
    pub(crate) fn following(&self, center: DVec3, size: f64) -> Self {
        let mut moved = self.clone();
        for (pose, within_reach) in moved.poses.iter_mut().zip(&mut moved.within_reach) {
            let position = center + pose.translation() * size;
            match check_position("position of a view", position) {
                Ok(()) => *pose = pose.with_translation(position),
                Err(_) => *within_reach = false,
            }
        }
        moved
    }

    /// Moves the candidates along their ray from `center` to where a camera of this range [measures the
    /// object](DepthRange::distances). `center` is the middle of an object of this half-side (metres).
    /// Candidates that measure it already stay where they are.
    pub fn within_range(mut self, center: DVec3, size: f64, range: DepthRange) -> Self {
        let (least, largest) = range.distances(size);
        for pose in &mut self.poses {
            let offset = pose.translation() - center;
            let distance = offset.length();
            // A camera in the middle has no ray.
            if distance > 0.0 && !(least..=largest).contains(&distance) {
                *pose = pose.with_translation(center + offset * (distance.clamp(least, largest) / distance));
            }
        }
        self
    }

    /// Keeps within reach only the candidates whose camera can stand at its position.
    pub fn restricted(mut self, can_stand: impl Fn(DVec3) -> bool) -> Self {
        for (within_reach, pose) in self.within_reach.iter_mut().zip(&self.poses) {
            *within_reach &= can_stand(pose.translation());
        }
        self
    }

    /// Replaces the poses by those that a robot can hold; candidates without one are out of reach.
    pub fn held(mut self, reach: &dyn Reachability) -> Self {
        for (within_reach, pose) in self.within_reach.iter_mut().zip(&mut self.poses) {
            match within_reach.then(|| reach.held(pose)).flatten() {
                Some(held) => *pose = held,
                None => *within_reach = false,
            }
        }
        self
    }

    /// Keeps within reach only the candidates with the given numbers.
    pub(crate) fn only(mut self, is_left: impl Fn(usize) -> bool) -> Self {
        self.within_reach
            .iter_mut()
            .enumerate()
            .for_each(|(view, within_reach)| *within_reach &= is_left(view));
        self
    }

    /// Whether candidate `view`, which must be below [`len`](Self::len), is within reach of the camera.
    pub fn is_within_reach(&self, view: usize) -> bool {
        self.within_reach[view]
    }

    /// Number of candidates, including those out of reach; never 0.
    pub fn len(&self) -> usize {
        self.poses.len()
    }

    /// Always false: a view space has at least one candidate.
    pub fn is_empty(&self) -> bool {
        self.poses.is_empty()
    }

    /// Returns the pose of candidate `view`, which must be below [`len`](Self::len).
    pub fn pose(&self, view: usize) -> Pose {
        self.poses[view]
    }

    /// Returns all poses in the order of their numbers.
    pub fn poses(&self) -> &[Pose] {
        &self.poses
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::view::generate;

    #[test]
    fn a_rule_for_size_one_serves_every_object() {
        let (center, size) = (DVec3::new(0.3, -0.1, 0.2), 0.07);
        let moved = generate::shell(DVec3::ZERO, 1.0, 40, 5).unwrap().around(center, size).unwrap();
        let made = generate::shell(center, size, 40, 5).unwrap();
        for (a, b) in moved.poses().iter().zip(made.poses()) {
            assert!(a.translation().distance(b.translation()) < 1e-15);
            assert!(a.rotation().dot(b.rotation()).abs() > 1.0 - 1e-12);
        }
    }

    #[test]
    fn candidates_move_along_their_ray_into_the_range() {
        let (center, size) = (DVec3::new(0.3, -0.1, 0.2), 0.05);
        let all = generate::shell(center, size, 300, 5).unwrap();
        assert_eq!(all.clone().within_range(center, size, DepthRange::default()), all);
        let range = DepthRange { min: 0.1, max: 0.18 };
        let moved = all.clone().within_range(center, size, range);
        for (before, after) in all.poses().iter().zip(moved.poses()) {
            let [a, b] = [before, after].map(|pose| pose.translation() - center);
            assert!(a.normalize().distance(b.normalize()) < 1e-12);
            assert!((b.length() - a.length().clamp(0.15, 0.18)).abs() < 1e-12);
            assert_eq!(before.rotation(), after.rotation());
        }
    }

    #[test]
    fn candidates_out_of_reach_keep_their_numbers() {
        let all = generate::shell(DVec3::ZERO, 0.1, 40, 5).unwrap();
        let upper = all.clone().restricted(|position| position.z > 0.0);
        assert_eq!(upper.poses(), all.poses());
        for view in 0..40 {
            assert!(all.is_within_reach(view));
            assert_eq!(upper.is_within_reach(view), all.pose(view).translation().z > 0.0);
        }
    }
}
