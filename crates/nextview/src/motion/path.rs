use crate::Error;
use crate::checked::check_range;
use crate::geometry::{Aabb, check_position};
use glam::{DQuat, DVec3};
use std::f64::consts::PI;

/// A ball around an object, which a moving camera must not enter.
///
/// The shortest path around it is straight, or a tangent, an arc on the ball and another tangent. It leaves
/// and reaches a position inside the ball along the radius.
///
/// ```
/// use glam::DVec3;
/// use nextview::motion::KeepOut;
///
/// let ball = KeepOut::new(DVec3::ZERO, 0.2, 0.05).unwrap();
/// let path = ball.path(DVec3::X, -DVec3::X);
/// assert!(path.iter().all(|point| point.length() >= 0.25));
/// let length = ball.path_length(DVec3::X, -DVec3::X);
/// assert!(length > 2.0 && length < 2.1);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct KeepOut {
    pub(super) center: DVec3,
    pub(super) radius: f64,
}

/// Maximum angle between waypoints on an arc, radians. The path through them is up to 0.07 % longer than the
/// arc.
pub(super) const MAX_TURN: f64 = 5.0 * PI / 180.0;

/// Maximum radius and clearance, metres.
const LARGEST: f64 = 1e9;

impl KeepOut {
    /// Creates a ball of this radius around `center`, enlarged by `clearance` (metres, 0 to 1e9). The centre
    /// must be within [`Pose::REACH`](crate::geometry::Pose::REACH).
    pub fn new(center: DVec3, radius: f64, clearance: f64) -> Result<Self, Error> {
        check_position("center", center)?;
        for (name, length) in [("radius", radius), ("clearance", clearance)] {
            check_range(name, length, 0.0..=LARGEST, "a length in metres, 0 to 1e9")?;
        }
        Ok(Self { center, radius: radius + clearance })
    }

    /// Creates the ball through the corners of a box, enlarged by `clearance` (metres).
    pub fn around(bounds: &Aabb, clearance: f64) -> Result<Self, Error> {
        Self::new(bounds.center(), 0.5 * bounds.size().length(), clearance)
    }

    /// Middle of the ball.
    pub fn center(&self) -> DVec3 {
        self.center
    }

    /// Radius of the ball with its clearance, metres.
    pub fn radius(&self) -> f64 {
        self.radius
    }

    /// Length of the shortest path between two positions, metres; equal in both directions.
    pub fn path_length(&self, from: DVec3, to: DVec3) -> f64 {
        if from == to {
            return 0.0;
        }
        let (a, b) = self.gates(from, to);
        let arc = self.arc(a, b);
        let around = self.radius * arc + (self.tangent_length(a) + self.tangent_length(b));
        let outside = if arc > 0.0 { around } else { a.distance(b) };
        outside + (from.distance(self.center + a) + to.distance(self.center + b))
    }

    /// Returns the waypoints of the shortest path, both ends included. Lines between them stay outside the
    /// ball, except from or to an end inside it. On an arc, waypoints lie slightly outside the ball.
    pub fn path(&self, from: DVec3, to: DVec3) -> Vec<DVec3> {
        self.path_by(from, to, None)
    }

    /// As [`path`](Self::path), but if all paths around are equally long, the one that turns about this axis,
    /// which is perpendicular to both ends.
    pub(super) fn path_by(&self, from: DVec3, to: DVec3, preferred: Option<DVec3>) -> Vec<DVec3> {
        if from == to {
            return vec![from];
        }
        let (a, b) = self.gates(from, to);
        let mut path = vec![from];
        path.extend(self.is_inside(from).then_some(self.center + a));
        path.extend(self.corners(a, b, preferred).map(|corner| self.center + corner));
        path.extend(self.is_inside(to).then_some(self.center + b));
        path.push(to);
        path
    }

    pub(super) fn is_inside(&self, position: DVec3) -> bool {
        position.distance(self.center) < self.radius
    }

    /// Where the part outside the ball begins and ends, relative to the centre: at the ends, or radially
    /// above those that are inside. From the exact centre, all paths out are equally long; the one below the
    /// other end is taken.
    fn gates(&self, from: DVec3, to: DVec3) -> (DVec3, DVec3) {
        let gate = |end: DVec3, other: DVec3| {
            let upward =
                (end - self.center).try_normalize().or_else(|| (other - self.center).try_normalize());
            if self.is_inside(end) { upward.unwrap_or(DVec3::Z) * self.radius } else { end - self.center }
        };
        (gate(from, to), gate(to, from))
    }

    /// The angle by which the path turns around the ball; not positive if the ends see each other.
    fn arc(&self, a: DVec3, b: DVec3) -> f64 {
        a.cross(b).length().atan2(a.dot(b)) - (self.tangent_angle(a) + self.tangent_angle(b))
    }

    /// Length of the tangent from a position to the ball; 0 on the ball.
    fn tangent_length(&self, offset: DVec3) -> f64 {
        (offset.length_squared() - self.radius * self.radius).max(0.0).sqrt()
    }

    /// Angle at the centre between a position and its tangent point.
    fn tangent_angle(&self, offset: DVec3) -> f64 {
        self.tangent_length(offset).atan2(self.radius)
    }

    /// Corners of the path around the ball, relative to its centre: a polygon that touches the arc with all
    /// its sides; its first and last sides are the tangents.
    fn corners(&self, a: DVec3, b: DVec3, preferred: Option<DVec3>) -> impl Iterator<Item = DVec3> {
        let axis = axis(a, b, preferred);
        let (arc, start) = (self.arc(a, b).max(0.0), self.tangent_angle(a));
        let n = (arc / MAX_TURN).ceil();
        let (turn, out) = (arc / n, self.radius / (0.5 * arc / n).cos());
        let upward = a.normalize_or_zero();
        (0..n as usize)
            .map(move |i| DQuat::from_axis_angle(axis, start + (i as f64 + 0.5) * turn) * upward * out)
    }
}

/// The unit vector around which the path turns from `a` to `b`; if they are opposite, to a millionth, the
/// preferred one or any perpendicular to `a`.
fn axis(a: DVec3, b: DVec3, preferred: Option<DVec3>) -> DVec3 {
    let cross = a.cross(b);
    if cross.length() > 1e-6 * a.length() * b.length() {
        cross.normalize()
    } else {
        preferred.unwrap_or_else(|| a.try_normalize().unwrap_or(DVec3::Z).any_orthonormal_vector())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Tolerance for rounding, metres.
    const TOLERANCE: f64 = 1e-9;

    fn ball() -> KeepOut {
        KeepOut::new(DVec3::new(0.1, -0.2, 0.3), 0.4, 0.1).unwrap()
    }

    fn position() -> impl Strategy<Value = DVec3> {
        let spread =
            prop::array::uniform3(-1.5..1.5).prop_map(|offset| ball().center() + DVec3::from_array(offset));
        // On the axes through the centre, where many ends are opposite or the same.
        let lined_up = (0_usize..3, prop::sample::select(vec![-2.0, -1.0, -0.5, 0.0, 0.3, 0.5, 0.7]))
            .prop_map(|(axis, at)| ball().center() + DVec3::AXES[axis] * at);
        prop_oneof![4 => spread, 1 => lined_up]
    }

    fn length(path: &[DVec3]) -> f64 {
        path.windows(2).map(|leg| leg[0].distance(leg[1])).sum()
    }

    /// Distance between a segment and the centre.
    fn clearance(leg: &[DVec3]) -> f64 {
        let (from, along) = (leg[0] - ball().center(), leg[1] - leg[0]);
        let t = if along == DVec3::ZERO {
            0.0
        } else {
            (-from.dot(along) / along.length_squared()).clamp(0.0, 1.0)
        };
        (from + t * along).length()
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(2000))]

        #[test]
        fn keeps_out_and_is_hardly_longer_than_a_line(from in position(), to in position()) {
            let (ball, straight) = (ball(), from.distance(to));
            let (path, shortest) = (ball.path(from, to), ball.path_length(from, to));
            prop_assert_eq!((path[0], path[path.len() - 1]), (from, to));
            prop_assert!(shortest >= straight - TOLERANCE);
            prop_assert!(length(&path) >= shortest - TOLERANCE && length(&path) <= 1.0007 * shortest + TOLERANCE);
            prop_assert_eq!(shortest, ball.path_length(to, from));
            prop_assert!((length(&path) - length(&ball.path(to, from))).abs() < TOLERANCE);
            // Never deeper in the ball than an end.
            let depth = |end: DVec3| end.distance(ball.center()).min(ball.radius());
            let deepest = depth(from).min(depth(to));
            prop_assert!(path.windows(2).all(|leg| clearance(leg) >= deepest - TOLERANCE), "{:?}", path);
            if !ball.is_inside(from) && !ball.is_inside(to) {
                prop_assert!(shortest <= 0.5 * PI * straight + TOLERANCE, "{} for {}", shortest, straight);
                let sees = clearance(&[from, to]) > ball.radius() + TOLERANCE;
                prop_assert!(!sees || (path.len() <= 2 && (shortest - straight).abs() < TOLERANCE));
            }
        }

        /// The slow twin: no path through a third point on the ball is shorter.
        #[test]
        fn is_the_shortest(from in position(), to in position(), via in prop::array::uniform3(-1.0..1.0)) {
            let ball = ball();
            let via = DVec3::from_array(via).try_normalize().unwrap_or(DVec3::X);
            let via = ball.center() + via * (ball.radius() + 1e-12);
            let over = ball.path_length(from, via) + ball.path_length(via, to);
            prop_assert!(from == to || ball.path_length(from, to) <= over + TOLERANCE);
        }
    }

    #[test]
    fn known_lengths() {
        let ball = KeepOut::new(DVec3::ZERO, 1.0, 0.0).unwrap();
        let check = |from, to, expected: f64| {
            let found = ball.path_length(from, to);
            assert!((found - expected).abs() < 1e-12, "{from} to {to}: {found}, not {expected}");
        };
        check(DVec3::X * 2.0, -DVec3::X * 2.0, 2.0 * 3.0_f64.sqrt() + PI / 3.0);
        check(DVec3::X, -DVec3::X, PI);
        check(DVec3::X * 2.0, DVec3::X * 3.0, 1.0);
        check(DVec3::X * 0.25, -DVec3::X * 0.5, 0.75 + PI + 0.5);
        check(DVec3::ZERO, DVec3::Y * 3.0, 3.0);
        check(DVec3::ZERO, DVec3::ZERO, 0.0);
        let point = KeepOut::new(DVec3::ZERO, 0.0, 0.0).unwrap();
        assert_eq!(point.path(DVec3::X, -DVec3::X), [DVec3::X, -DVec3::X]);
    }

    #[test]
    fn refuses_what_is_no_ball() {
        assert!(KeepOut::new(DVec3::splat(f64::NAN), 1.0, 0.0).is_err());
        assert!(KeepOut::new(DVec3::ZERO, -1.0, 0.0).is_err());
        assert!(KeepOut::new(DVec3::ZERO, 1.0, f64::INFINITY).is_err());
        assert!(
            (KeepOut::around(&Aabb::cube(DVec3::ONE, 0.5), 0.1).unwrap().radius() - 0.1 - 0.75_f64.sqrt())
                .abs()
                < 1e-15
        );
    }
}
