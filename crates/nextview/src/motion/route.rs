use super::KeepOut;
use crate::geometry::Plane;
use glam::DVec3;

/// A path around a ball and above a floor: straight lines between corners, both ends included.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Detour {
    pub corners: Vec<DVec3>,
    /// Radius of the arc that the corners follow if the path is not straight, metres.
    pub radius: f64,
}

impl KeepOut {
    /// Returns the [shortest path](Self::path) if it is nowhere below the floor, otherwise a path level with
    /// its ends. That path lies in the most level plane through both ends, where the ball is a circle, and
    /// leaves and reaches an end inside the ball level.
    ///
    /// No point is lower than the floor, or than the lower end if that is below the floor.
    pub(super) fn route(&self, from: DVec3, to: DVec3, floor: Option<&Plane>) -> Detour {
        let corners = self.path(from, to);
        let dips = |floor: &&Plane| {
            let lowest = floor.height(from).min(floor.height(to)).min(0.0);
            corners.iter().any(|corner| floor.height(*corner) < lowest)
        };
        match floor.filter(dips) {
            Some(floor) => self.level_route(from, to, floor.normal()),
            None => Detour { corners, radius: self.radius },
        }
    }

    /// In its plane, the whole path is to the side of the line between the gates, never before or behind it,
    /// and so no lower than the lower gate. It is at most pi / 2 times as long as that line, as around every
    /// circle with both ends outside.
    fn level_route(&self, from: DVec3, to: DVec3, up: DVec3) -> Detour {
        let (a, b) = (self.level_gate(from, to, up), self.level_gate(to, from, up));
        let beside = up.cross(b - a).try_normalize().unwrap_or_else(|| up.any_orthonormal_vector());
        let normal = (b - a).cross(beside).normalize_or(up);
        let depth = normal.dot(a - self.center);
        let radius = (self.radius.powi(2) - depth * depth).max(0.0).sqrt();
        let circle = Self { center: self.center + depth * normal, radius };
        let mut corners = vec![from];
        corners.extend(circle.path_by(a, b, Some(normal)));
        corners.push(to);
        corners.dedup();
        Detour { corners, radius }
    }

    /// The end itself. For an end inside the ball, the point level with it where the path leaves the ball,
    /// away from the middle; on the axis through the middle, towards the other end.
    fn level_gate(&self, end: DVec3, other: DVec3, up: DVec3) -> DVec3 {
        if !self.is_inside(end) {
            return end;
        }
        let level = |offset: DVec3| (offset - up * up.dot(offset)).try_normalize();
        let outward = level(end - self.center).or_else(|| level(other - self.center));
        let height = up.dot(end - self.center);
        let reach = (self.radius.powi(2) - height * height).max(0.0).sqrt();
        self.center + up * height + outward.unwrap_or_else(|| up.any_orthonormal_vector()) * reach
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::random::Random;
    use std::f64::consts::{FRAC_PI_2, SQRT_2};

    const TOLERANCE: f64 = 1e-9;

    fn length(corners: &[DVec3]) -> f64 {
        corners.windows(2).map(|leg| leg[0].distance(leg[1])).sum()
    }

    /// Distance between a line segment and a point.
    fn distance(leg: &[DVec3], point: DVec3) -> f64 {
        let along = leg[1] - leg[0];
        let t = (point - leg[0]).dot(along) / along.length_squared();
        (leg[0] + t.clamp(0.0, 1.0) * along).distance(point)
    }

    /// A ball, a tilted floor that usually cuts it, and two positions: most outside and above, many of them
    /// low, some opposite.
    fn case(random: &mut Random) -> (KeepOut, Plane, [DVec3; 2]) {
        let center = random.in_cube();
        let ball = KeepOut::new(center, random.range(0.05, 0.5), random.range(0.0, 0.1)).unwrap();
        let up = (DVec3::Z + 0.3 * random.in_cube()).normalize();
        let floor = Plane::new(up, center - up * ball.radius() * random.range(-0.5, 1.5)).unwrap();
        let is_free = |at: DVec3| !ball.is_inside(at) && floor.height(at) >= 0.0;
        let is_any = random.unit() < 0.1;
        let mut position = || loop {
            let high = center + 3.0 * ball.radius() * random.in_cube();
            let lowered = if random.unit() < 0.5 { random.unit() } else { 0.0 };
            let position = high - up * lowered * floor.height(high);
            if is_any || is_free(position) {
                return position;
            }
        };
        let (from, to) = (position(), position());
        let opposite = 2.0 * center - from;
        (ball, floor, [from, if random.unit() < 0.1 && is_free(opposite) { opposite } else { to }])
    }

    /// Every path between a million random pairs of positions, with and without a floor.
    #[test]
    fn a_million_ways_keep_out_and_above_and_short() {
        let mut random = Random::new(7, 0);
        let (mut n_around, mut n_level, mut longest) = (0, 0, 0.0_f64);
        for _ in 0..1_000_000 {
            let (ball, floor, [from, to]) = case(&mut random);
            for floor in [None, Some(&floor)] {
                let Detour { corners, .. } = ball.route(from, to, floor);
                assert_eq!((corners.first(), corners.last()), (Some(&from), Some(&to)));
                let depth = |end: DVec3| end.distance(ball.center()).min(ball.radius());
                let deepest = depth(from).min(depth(to));
                for leg in corners.windows(2).filter(|leg| leg[0] != leg[1]) {
                    assert!(distance(leg, ball.center()) >= deepest - TOLERANCE, "{corners:?}");
                }
                if let Some(floor) = floor {
                    let lowest = floor.height(from).min(floor.height(to)).min(0.0);
                    assert!(corners.iter().all(|p| floor.height(*p) >= lowest - TOLERANCE), "{corners:?}");
                    n_level += (corners != ball.path(from, to)) as usize;
                }
                if !ball.is_inside(from) && !ball.is_inside(to) && from != to {
                    longest = longest.max(length(&corners) / from.distance(to));
                    n_around += (corners.len() > 2) as usize;
                }
            }
        }
        assert!(longest <= 1.0007 * FRAC_PI_2, "{longest} times straight");
        assert!(n_around > 100_000 && n_level > 10_000, "{n_around} around, {n_level} level");
    }

    #[test]
    fn known_ways_above_a_floor() {
        let ball = KeepOut::new(DVec3::Z * 0.5, 1.0, 0.0).unwrap();
        let floor = Plane::horizontal(0.0).unwrap();
        let of = |from, to| ball.route(from, to, Some(&floor));
        // The circle on the floor is touched from 60 degrees off the line to its middle.
        let radius = 0.75_f64.sqrt();
        let low = |x: f64, y: f64| 2.0 * radius * DVec3::new(x, y, 0.0);
        let around = of(low(1.0, 0.0), low(-0.99_f64, (1.0 - 0.99_f64 * 0.99).sqrt()));
        assert!(around.corners.iter().all(|p| p.z.abs() < 1e-12) && (around.radius - radius).abs() < 1e-12);
        let opposite = of(low(1.0, 0.0), low(-1.0, 0.0));
        let expected = radius * (2.0 * 3.0_f64.sqrt() + FRAC_PI_2 * 2.0 / 3.0);
        assert!((length(&opposite.corners) / expected - 1.0).abs() < 1e-3);
        assert!(opposite.corners.iter().all(|p| p.z.abs() < 1e-12));
        // From high enough, the shortest path leads over the ball.
        let high = of(DVec3::new(SQRT_2, 0.0, 1.0), DVec3::new(-SQRT_2, 0.0, 1.0));
        assert_eq!(high.corners, ball.path(DVec3::new(SQRT_2, 0.0, 1.0), DVec3::new(-SQRT_2, 0.0, 1.0)));
    }
}
