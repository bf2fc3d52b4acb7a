//! The pose of a frame in its parent over time.

use nextview::geometry::Pose;
use std::collections::VecDeque;

/// Times and poses in ascending order, without duplicate times.
#[derive(Clone, Debug, Default)]
pub(super) struct TimedPoses(VecDeque<(f64, Pose)>);

/// The reason why there is no pose at a time; times in seconds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Missing {
    Before { first: f64 },
    After { last: f64 },
    Gap { from: f64, to: f64 },
}

/// Longest gap, in seconds, across which a moving frame is interpolated: its motion in the gap is unknown,
/// and transforms may arrive out of order, so one in the gap may still come.
const LONGEST_GAP: f64 = 0.5;

impl TimedPoses {
    /// The newest time in seconds.
    pub fn newest(&self) -> Option<f64> {
        self.0.back().map(|(time, _)| *time)
    }

    /// Adds a pose, or replaces the one at the same time.
    pub fn insert(&mut self, time: f64, pose: Pose) {
        let at = self.0.partition_point(|(earlier, _)| *earlier < time);
        match self.0.get_mut(at) {
            Some(same) if same.0 == time => same.1 = pose,
            _ => self.0.insert(at, (time, pose)),
        }
    }

    /// Removes everything before this time, except the last pose before it.
    pub fn forget_before(&mut self, time: f64) {
        while self.0.get(1).is_some_and(|(second, _)| *second <= time) {
            self.0.pop_front();
        }
    }

    /// The pose at a time, interpolated between its neighbours: the position on a straight line, the rotation
    /// on the shortest arc (Shoemake 1985, slerp), both at constant speed.
    pub fn at(&self, time: f64) -> Result<Pose, Missing> {
        let later = self.0.partition_point(|(earlier, _)| *earlier < time);
        let before = later.checked_sub(1).and_then(|i| self.0.get(i));
        match (before, self.0.get(later)) {
            (_, Some((same, pose))) if *same == time => Ok(*pose),
            (Some((from, a)), Some((to, b))) => {
                match () {
                    // A frame at rest stays exact to the last bit: a bit may change a plan.
                    () if a == b => Ok(*a),
                    () if to - from > LONGEST_GAP => Err(Missing::Gap { from: *from, to: *to }),
                    () => Ok(between(a, b, (time - from) / (to - from))),
                }
            }
            (None, Some((first, _))) => Err(Missing::Before { first: *first }),
            (last, None) => Err(Missing::After { last: last.map_or(f64::NEG_INFINITY, |(last, _)| *last) }),
        }
    }
}

/// The pose at this share, 0..=1, of the way from one to another.
fn between(a: &Pose, b: &Pose, share: f64) -> Pose {
    let position = a.translation().lerp(b.translation(), share);
    let rotation = a.rotation().slerp(b.rotation(), share).normalize();
    Pose::new(rotation, position).expect("it lies between two poses")
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{DQuat, DVec3};
    use proptest::prelude::*;

    fn pose(turn: f64, x: f64) -> Pose {
        Pose::new(DQuat::from_rotation_z(turn), DVec3::X * x).unwrap()
    }

    #[test]
    fn half_way_is_half_the_arc_and_half_the_line() {
        let mut motion = TimedPoses::default();
        motion.insert(2.0, pose(1.0, 3.0));
        motion.insert(1.5, pose(0.2, 1.0));
        // The negated quaternion is the same rotation and still takes the short arc.
        let turned = pose(1.0, 3.0);
        motion.insert(2.0, Pose::new(-turned.rotation(), turned.translation()).unwrap());
        let half = motion.at(1.75).unwrap();
        assert!(half.translation().distance(DVec3::X * 2.0) < 1e-12);
        assert!(half.rotation().dot(pose(0.6, 0.0).rotation()).abs() > 1.0 - 1e-12);
        assert_eq!(motion.at(1.5), Ok(pose(0.2, 1.0)));
        assert_eq!(motion.at(1.4), Err(Missing::Before { first: 1.5 }));
        assert_eq!(motion.at(2.1), Err(Missing::After { last: 2.0 }));
    }

    #[test]
    fn nothing_is_guessed_in_long_gaps_unless_it_stands_still() {
        let mut motion = TimedPoses::default();
        for (time, x) in [(0.0, 1.0), (5.0, 1.0), (7.0, 2.0)] {
            motion.insert(time, pose(0.0, x));
        }
        assert_eq!(motion.at(3.0), Ok(pose(0.0, 1.0)));
        assert_eq!(motion.at(6.0), Err(Missing::Gap { from: 5.0, to: 7.0 }));
    }

    proptest! {
        /// The order of arrival does not matter: the slow twin looks at all entries.
        #[test]
        fn the_order_of_arrival_does_not_matter(times in prop::collection::vec(0..40_u32, 1..30), asked in 0..160_u32) {
            let mut motion = TimedPoses::default();
            times.iter().for_each(|&time| motion.insert(0.25 * time as f64, pose(0.0, time as f64)));
            let time = 0.0625 * asked as f64;
            let entries = times.iter().map(|&entry| 0.25 * entry as f64);
            let before = entries.clone().filter(|entry| *entry <= time).reduce(f64::max);
            let after = entries.filter(|entry| *entry >= time).reduce(f64::min);
            match (motion.at(time), before, after) {
                (Ok(found), Some(_), Some(_)) => prop_assert!((found.translation().x - 4.0 * time).abs() < 1e-9),
                (Err(Missing::Before { first }), None, Some(after)) => prop_assert_eq!(first, after),
                (Err(Missing::After { last }), Some(before), None) => prop_assert_eq!(last, before),
                (Err(Missing::Gap { from, to }), Some(before), Some(after)) => {
                    prop_assert_eq!((from, to), (before, after));
                    prop_assert!(to - from > 0.5);
                }
                other => prop_assert!(false, "{:?}", other),
            }
        }
    }
}
