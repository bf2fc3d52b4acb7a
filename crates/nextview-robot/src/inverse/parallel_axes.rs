use super::axis::JointAxis;
use super::circle::{angle_of, angles_between, angles_to_distance, angles_to_product};
use super::free::Free;
use glam::DVec3;
use nextview::geometry::Pose;

/// Six axes of which the second to fourth are parallel and the last two meet, as in the arms of Universal
/// Robots (Hawkins 2013).
pub(super) struct ParallelAxes {
    axes: [JointAxis; 6],
    /// Intersection of the last two axes.
    center: DVec3,
}

impl ParallelAxes {
    pub fn of(axes: &[JointAxis; 6]) -> Option<Self> {
        let [first, second, third, fourth, fifth, sixth] = axes;
        let is_planar = second.is_parallel(third) && second.is_parallel(fourth);
        if !is_planar || first.is_parallel(second) || fifth.is_parallel(second) {
            return None;
        }
        Some(Self { axes: *axes, center: fifth.meets(sixth)? })
    }

    /// The joint angles that produce `motion`, as seen from the base.
    pub fn solve(&self, motion: &Pose, free: &Free) -> Vec<[f64; 6]> {
        let [first, second, _, _, fifth, sixth] = &self.axes;
        // Turning about the parallel axes preserves a point's position along them, and the last two fix the
        // center.
        let normal = second.direction;
        let height = normal.dot(self.center - first.point);
        let to_target = motion.transform_point(self.center) - first.point;
        let mut solutions = Vec::new();
        for a in angles_to_product(first.direction, normal, to_target, height, &free.values(0)) {
            let rest = first.motion(-a) * *motion;
            let tilt = normal.dot(rest.rotation() * sixth.direction);
            for e in angles_to_product(fifth.direction, sixth.direction, normal, tilt, &free.values(4)) {
                let from = rest.rotation().conjugate() * normal;
                let to = fifth.rotation(-e) * normal;
                for f in angles_between(sixth.direction, from, to, &free.values(5)) {
                    let planar = rest * sixth.motion(-f) * fifth.motion(-e);
                    let between = self.move_in_plane(&planar, free);
                    solutions.extend(between.into_iter().map(|[b, c, d]| [a, b, c, d, e, f]));
                }
            }
        }
        solutions
    }

    /// The angles of the parallel axes for a motion in their plane.
    fn move_in_plane(&self, motion: &Pose, free: &Free) -> Vec<[f64; 3]> {
        let [_, second, third, fourth, ..] = &self.axes;
        let normal = second.direction;
        // Turning about the fourth axis does not move this point.
        let target = motion.transform_point(fourth.point);
        // Only distances in the plane count.
        let level = |point: DVec3| point - normal * normal.dot(point - second.point);
        let distance = level(target).distance(second.point);
        let thirds = angles_to_distance(
            third.direction,
            level(third.point),
            level(fourth.point),
            second.point,
            distance,
            &free.values(2),
        );
        let mut solutions = Vec::new();
        for c in thirds {
            let from = third.turned(c, fourth.point) - second.point;
            for b in angles_between(normal, from, target - second.point, &free.values(1)) {
                let rest = (second.rotation(b) * third.rotation(c)).conjugate() * motion.rotation();
                solutions.push([b, c, angle_of(fourth.direction, rest)]);
            }
        }
        solutions
    }
}
