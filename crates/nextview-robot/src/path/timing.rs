use super::JointPath;
use crate::{Arm, Joint};
use nextview::motion::SpeedProfile;

/// Joint values over time.
#[derive(Clone, Debug, PartialEq)]
pub struct JointTrajectory {
    /// Names of the joints, in the order of the values.
    pub names: Vec<String>,
    /// Seconds from the start, and the value of each joint then, radians or metres. Times increase from 0.
    /// Between points, values change linearly.
    pub points: Vec<(f64, Vec<f64>)>,
}

impl JointTrajectory {
    /// Maximum time between points in seconds.
    pub const LONGEST_STEP: f64 = 0.1;

    /// Returns the fastest motion along a path within the joint limits that stops at every corner.
    ///
    /// Every point is on the path, and every corner is a point: the motion is as free as the path. Rounded
    /// corners would be faster, but leave the path.
    ///
    /// # Panics
    ///
    /// If the number of values is not that of joints.
    pub fn along(path: &JointPath, arm: &Arm) -> Self {
        let corners = path.corners();
        let mut points = vec![(0.0, corners[0].clone())];
        let mut start = 0.0;
        for leg in corners.windows(2) {
            let profile = profile(arm, &leg[0], &leg[1]);
            let duration = profile.duration();
            let n_steps = (duration / Self::LONGEST_STEP).ceil();
            for i in 1..n_steps as usize {
                let time = i as f64 / n_steps * duration;
                points.push((start + time, between(&leg[0], &leg[1], profile.distance_at(time))));
            }
            if duration > 0.0 {
                start += duration;
                points.push((start, leg[1].clone()));
            }
        }
        Self { names: arm.joints.iter().map(|joint| joint.name.clone()).collect(), points }
    }

    /// Duration in seconds.
    pub fn duration(&self) -> f64 {
        self.points.last().map_or(0.0, |(time, _)| *time)
    }
}

/// Duration of the straight motion between joint values, from rest to rest, in seconds.
pub fn motion_time(arm: &Arm, from: &[f64], to: &[f64]) -> f64 {
    profile(arm, from, to).duration()
}

/// Duration of straight motions along all of these corners in seconds.
pub(super) fn duration(arm: &Arm, corners: &[Vec<f64>]) -> f64 {
    corners.windows(2).map(|leg| motion_time(arm, &leg[0], &leg[1])).sum()
}

/// Values at a share of the way.
pub(super) fn between(from: &[f64], to: &[f64], share: f64) -> Vec<f64> {
    from.iter().zip(to).map(|(from, to)| from + share * (to - from)).collect()
}

/// Share of the way over time. All joints move in proportion: the slowest one decides.
fn profile(arm: &Arm, from: &[f64], to: &[f64]) -> SpeedProfile {
    assert_eq!(from.len(), arm.n_joints(), "a value for each joint");
    let least = |limit: &dyn Fn(&Joint) -> f64| {
        let shares = arm.joints.iter().zip(from.iter().zip(to));
        let shares = shares.map(|(joint, (from, to))| limit(joint) / (to - from).abs());
        shares.fold(f64::INFINITY, f64::min)
    };
    let (speed, acceleration) = (least(&|joint| joint.limits.velocity), least(&|j| j.limits.acceleration));
    if speed == f64::INFINITY {
        return SpeedProfile::new(0.0, 1.0, 1.0);
    }
    SpeedProfile::new(1.0, speed, acceleration)
}
