//! Detects a camera at rest near the wanted pose.

use nextview::geometry::Pose;
use std::collections::VecDeque;

/// Recent poses of the camera, oldest first.
#[derive(Default)]
pub struct RecentPoses(VecDeque<(f64, Pose)>);

/// Maximum motion of a resting camera, in metres and radians, and its minimum duration in seconds: a blurred
/// image, or a pose of another moment, is worse than waiting.
const MOVED: f64 = 0.002;
const TURNED: f64 = 0.005;
const TIME: f64 = 0.4;

impl RecentPoses {
    /// Records the camera's pose at this time in seconds. Times not later than the last are ignored, and old
    /// entries are dropped.
    pub fn saw(&mut self, time: f64, pose: Pose) {
        match self.0.back() {
            Some((last, _)) if time <= *last && time > last - TIME => return,
            Some((last, _)) if time <= *last => self.0.clear(),
            _ => (),
        }
        self.0.push_back((time, pose));
        while self.0.get(1).is_some_and(|(second, _)| *second <= time - TIME) {
            self.0.pop_front();
        }
    }

    /// Pose of the resting camera; `None` if the camera moves, or its poses do not reach back far enough.
    pub fn place(&self) -> Option<Pose> {
        let (last, now) = self.0.back()?;
        let (first, _) = self.0.front()?;
        let is_still = |(_, pose): &(f64, Pose)| {
            pose.translation().distance(now.translation()) <= MOVED
                && pose.rotation().angle_between(now.rotation()) <= TURNED
        };
        (*first <= last - TIME && self.0.iter().all(is_still)).then_some(*now)
    }
}

/// Whether a camera sees nearly the same at both poses: positions within a distance in metres, directions
/// within an angle in radians. Rotation about the optical axis is ignored.
pub fn is_near(a: &Pose, b: &Pose, distance: f64, angle: f64) -> bool {
    let axis = |pose: &Pose| pose.rotation() * glam::DVec3::Z;
    a.translation().distance(b.translation()) <= distance && axis(a).angle_between(axis(b)) <= angle
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{DQuat, DVec3};

    fn at(x: f64) -> Pose {
        Pose::new(DQuat::IDENTITY, DVec3::X * x).unwrap()
    }

    #[test]
    fn a_camera_rests_after_a_while() {
        let mut rest = RecentPoses::default();
        for i in 0..60 {
            // It stops at 1 s.
            let time = i as f64 / 30.0;
            rest.saw(time, at(0.1 * (1.0 - time).max(0.0)));
            // A moment earlier, it has nearly stopped.
            assert!(rest.place().is_none() || time >= 1.35, "{time}");
            assert!(rest.place().is_some() || time <= 1.45, "{time}");
        }
        assert!(rest.0.len() < 20);
        rest.saw(1.9, at(0.5));
        assert!(rest.place().is_some(), "an old image does not count");
        rest.saw(2.0, at(0.01));
        assert!(rest.place().is_none());
        // The clock restarts.
        rest.saw(0.1, at(0.0));
        assert_eq!(rest.0.len(), 1);
    }

    #[test]
    fn near_is_near_in_place_and_direction() {
        let turned =
            Pose::new(DQuat::from_rotation_x(0.05) * DQuat::from_rotation_z(2.0), DVec3::ZERO).unwrap();
        assert!(is_near(&at(0.0), &at(0.009), 0.01, 0.01) && !is_near(&at(0.0), &at(0.011), 0.01, 0.01));
        assert!(is_near(&at(0.0), &turned, 0.01, 0.051) && !is_near(&at(0.0), &turned, 0.01, 0.049));
    }
}
