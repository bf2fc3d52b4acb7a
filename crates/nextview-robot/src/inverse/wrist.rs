use super::axis::JointAxis;
use super::circle::{angle_of, angles_between, angles_to_distance, angles_to_product};
use super::free::Free;
use glam::{DQuat, DVec3};
use nextview::geometry::Pose;

/// Six axes of which the last three meet: the first three position their intersection, the others turn the
/// flange about it (Brandstötter et al. 2014).
pub(super) struct Wrist {
    axes: [JointAxis; 6],
    /// Intersection of the last three axes.
    center: DVec3,
    /// Intersection of the first two axes; `None` if the second and third are parallel instead.
    shoulder: Option<DVec3>,
}

impl Wrist {
    pub fn of(axes: &[JointAxis; 6]) -> Option<Self> {
        let center = axes[3].meets(&axes[4]).filter(|center| axes[5].passes(*center))?;
        if axes[4].is_parallel(&axes[5]) {
            return None;
        }
        let is_planar = axes[1].is_parallel(&axes[2]) && !axes[0].is_parallel(&axes[1]);
        let shoulder = if is_planar { None } else { Some(axes[0].meets(&axes[1])?) };
        Some(Self { axes: *axes, center, shoulder })
    }

    /// The joint angles that produce `motion`, as seen from the base.
    pub fn solve(&self, motion: &Pose, free: &Free) -> Vec<[f64; 6]> {
        let target = motion.transform_point(self.center);
        let firsts = match self.shoulder {
            Some(shoulder) => self.place_by_shoulder(shoulder, target, free),
            None => self.place_in_plane(target, free),
        };
        let mut solutions = Vec::new();
        for [a, b, c] in firsts {
            let [first, second, third] = [0, 1, 2].map(|i| self.axes[i].rotation([a, b, c][i]));
            let rest = (first * second * third).conjugate() * motion.rotation();
            solutions.extend(self.turn(rest, free).into_iter().map(|[d, e, f]| [a, b, c, d, e, f]));
        }
        solutions
    }

    /// Turning about the second and third axes preserves a point's position along them; this gives the first
    /// angle.
    fn place_in_plane(&self, target: DVec3, free: &Free) -> Vec<[f64; 3]> {
        let [first, second, third, ..] = &self.axes;
        let height = second.direction.dot(self.center - first.point);
        let to_target = target - first.point;
        let mut solutions = Vec::new();
        for a in angles_to_product(first.direction, second.direction, to_target, height, &free.values(0)) {
            let target = first.turned(-a, target);
            let distance = target.distance(second.point);
            let (center, reached) = (third.point, second.point);
            let thirds =
                angles_to_distance(third.direction, center, self.center, reached, distance, &free.values(2));
            for c in thirds {
                let from = third.turned(c, self.center) - second.point;
                let seconds = angles_between(second.direction, from, target - second.point, &free.values(1));
                solutions.extend(seconds.into_iter().map(|b| [a, b, c]));
            }
        }
        solutions
    }

    /// Turning about the first two axes preserves the distance from the shoulder; this gives the third angle.
    fn place_by_shoulder(&self, shoulder: DVec3, target: DVec3, free: &Free) -> Vec<[f64; 3]> {
        let [first, second, third, ..] = &self.axes;
        let (distance, to_target) = (target.distance(shoulder), target - shoulder);
        let thirds = angles_to_distance(
            third.direction,
            third.point,
            self.center,
            shoulder,
            distance,
            &free.values(2),
        );
        let mut solutions = Vec::new();
        for c in thirds {
            let arm = third.turned(c, self.center) - shoulder;
            let height = first.direction.dot(to_target);
            for b in angles_to_product(second.direction, arm, first.direction, height, &free.values(1)) {
                let from = second.rotation(b) * arm;
                let firsts = angles_between(first.direction, from, to_target, &free.values(0));
                solutions.extend(firsts.into_iter().map(|a| [a, b, c]));
            }
        }
        solutions
    }

    /// The last three angles for a rotation.
    fn turn(&self, rotation: DQuat, free: &Free) -> Vec<[f64; 3]> {
        let [.., fourth, fifth, sixth] = &self.axes;
        let to = rotation * sixth.direction;
        let height = fourth.direction.dot(to);
        let mut solutions = Vec::new();
        let fifths =
            angles_to_product(fifth.direction, sixth.direction, fourth.direction, height, &free.values(4));
        for e in fifths {
            let from = fifth.rotation(e) * sixth.direction;
            for d in angles_between(fourth.direction, from, to, &free.values(3)) {
                let rest = (fourth.rotation(d) * fifth.rotation(e)).conjugate() * rotation;
                solutions.push([d, e, angle_of(sixth.direction, rest)]);
            }
        }
        solutions
    }
}
