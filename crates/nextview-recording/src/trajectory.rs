//! Matches poses and images that have separate timestamps.

use crate::RecordingError;
use nextview::geometry::Pose;

/// An entry recorded at a time.
#[derive(Clone, Debug)]
pub(crate) struct Stamped<T> {
    /// Seconds.
    pub time: f64,
    /// Where the entry is in its file, as errors name it.
    pub place: String,
    pub value: T,
}

impl<T> Stamped<T> {
    /// Sorts by time. Fails if a time is not finite or occurs twice.
    pub fn sorted(mut entries: Vec<Self>) -> Result<Vec<Self>, RecordingError> {
        if let Some(bad) = entries.iter().find(|entry| !entry.time.is_finite()) {
            let problem = format!("the timestamp is {}, expected a number of seconds", bad.time);
            return Err(RecordingError::format(&bad.place, problem));
        }
        entries.sort_by(|a, b| a.time.total_cmp(&b.time));
        match entries.windows(2).find(|pair| pair[0].time == pair[1].time) {
            Some([first, again]) => {
                let problem = format!("has the same timestamp, {}, as {}", again.time, first.place);
                Err(RecordingError::format(&again.place, problem))
            }
            _ => Ok(entries),
        }
    }
}

/// The nearest entry in a list sorted by time, the earlier of two.
pub(crate) fn nearest<T>(entries: &[Stamped<T>], time: f64) -> Option<&Stamped<T>> {
    let later = entries.partition_point(|entry| entry.time < time);
    let around = [later.checked_sub(1), Some(later)].into_iter().flatten().filter_map(|i| entries.get(i));
    let distance = |entry: &&Stamped<T>| (entry.time - time).abs();
    around.min_by(|a, b| distance(a).total_cmp(&distance(b)))
}

/// The poses of the camera over time.
pub(crate) struct CameraTrajectory {
    poses: Vec<Stamped<Pose>>,
    tolerance: f64,
}

impl CameraTrajectory {
    /// Builds a trajectory from poses sorted by time; the tolerance is in seconds.
    pub fn new(poses: Vec<Stamped<Pose>>, tolerance: f64) -> Self {
        Self { poses, tolerance }
    }

    /// The pose nearest in time, the earlier of two; or why there is none.
    pub fn at(&self, time: f64) -> Result<Pose, String> {
        let nearest = nearest(&self.poses, time).ok_or("there is no pose")?;
        let apart = (nearest.time - time).abs();
        if apart <= self.tolerance {
            return Ok(nearest.value);
        }
        Err(format!(
            "the nearest pose ({}) is {:.0} ms away in time, more than {:.0} ms",
            nearest.place,
            1e3 * apart,
            1e3 * self.tolerance
        ))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{DQuat, DVec3};

    fn stamped(times: &[f64]) -> Vec<Stamped<Pose>> {
        let entry = |(i, &time): (usize, &f64)| Stamped {
            time,
            place: format!("line {}", i + 1),
            value: Pose::new(DQuat::IDENTITY, DVec3::X * time).unwrap_or(Pose::IDENTITY),
        };
        times.iter().enumerate().map(entry).collect()
    }

    #[test]
    fn the_nearest_pose_counts_if_it_is_near_enough() {
        let trajectory = CameraTrajectory::new(Stamped::sorted(stamped(&[3.0, 1.0, 2.0])).unwrap(), 0.25);
        let at = |time: f64| trajectory.at(time).map(|pose| pose.translation().x);
        assert_eq!(
            (at(0.75), at(1.25), at(1.75), at(2.1), at(3.25)),
            (Ok(1.0), Ok(1.0), Ok(2.0), Ok(2.0), Ok(3.0))
        );
        assert_eq!(
            at(0.5).unwrap_err(),
            "the nearest pose (line 2) is 500 ms away in time, more than 250 ms"
        );
        assert!(at(1.5).unwrap_err().contains("line 2") && at(4.0).unwrap_err().contains("line 1"));
    }

    #[test]
    fn times_are_finite_and_come_once() {
        let error = |times: &[f64]| Stamped::sorted(stamped(times)).unwrap_err().to_string();
        assert_eq!(error(&[2.0, 1.0, 2.0]), "line 3: has the same timestamp, 2, as line 1");
        assert!(error(&[1.0, f64::NAN]).contains("line 2: the timestamp is NaN"));
    }
}
