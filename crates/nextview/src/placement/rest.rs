use super::farthest::Farthest;
use crate::geometry::sphere;
use glam::DVec3;
use rayon::prelude::*;
use std::f64::consts::TAU;

/// Number of directions tried first, and their spacing, radians.
const N_DIRECTIONS: usize = 4000;
const SPACING: f64 = 0.06;

/// Maximum number of lower neighbours of a direction from which a minimum is searched.
const MOST_LOWER: usize = 2;

/// Tilt, radians, that an object must withstand in its pose without tipping over.
const TIP: f64 = 0.14;

/// First and last step of the search for a minimum, radians.
const STEPS: [f64; 2] = [0.03, 1e-4];

/// Relative difference up to which lengths are equal.
const TOLERANCE: f64 = 1e-9;

/// Number of points that may touch the plane.
const N_LOWEST: usize = 12;

/// Number of directions of a step.
const N_TURNS: usize = 12;

/// A pose in which an object lies still.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rest {
    /// The direction that points down in this pose, in the frame of the object, of unit length.
    pub down: DVec3,
    /// Height of the centre of mass above the supporting plane, metres.
    pub height: f64,
}

/// Returns the poses in which an object lies still on a plane, the lowest first. The arguments are points of
/// its surface and its centre of mass.
///
/// These are the local minima of the height of the centre of mass above the plane, over all directions that
/// can point down. A pose that tips over into a lower one when tilted by 8 degrees is left out; a rolling
/// object has many poses. Empty without points.
///
/// ```
/// use glam::DVec3;
/// use nextview::geometry::Aabb;
/// use nextview::placement::rests;
///
/// let brick = Aabb { min: DVec3::ZERO, max: DVec3::new(0.1, 0.06, 0.04) };
/// let found = rests(&brick.corners(), brick.center());
/// assert_eq!(found.len(), 6);
/// assert!(found[0].down.z.abs() > 0.999 && (found[0].height - 0.02).abs() < 1e-5);
/// ```
pub fn rests(points: &[DVec3], center_of_mass: DVec3) -> Vec<Rest> {
    if points.is_empty() {
        return Vec::new();
    }
    let points = outermost(points, center_of_mass);
    let farthest = Farthest::new(points.iter().copied());
    let height = |down: DVec3| farthest.along(down).expect("there are points").0;
    let directions: Vec<DVec3> = (0..N_DIRECTIONS).map(|i| sphere::fibonacci(i, N_DIRECTIONS)).collect();
    let heights: Vec<f64> = directions.par_iter().map(|down| height(*down)).collect();
    let n_lower = |of: DVec3, reach: f64, lowest: f64| {
        let least_dot = reach.cos();
        let is_lower = |j: &usize| heights[*j] < lowest && directions[*j].dot(of) >= least_dot;
        (0..N_DIRECTIONS).filter(is_lower).count()
    };
    // In a narrow valley between two directions, the lowest one may have lower neighbours.
    let is_start = |i: &usize| n_lower(directions[*i], SPACING, heights[*i]) <= MOST_LOWER;
    let starts = (0..N_DIRECTIONS).into_par_iter().filter(is_start);
    let minima = starts.filter_map(|i| on_three(lowest_near(directions[i], height), &points, height));
    let minima: Vec<Rest> = minima.filter(|rest| n_lower(rest.down, TIP, rest.height) == 0).collect();
    let mut found: Vec<Rest> = Vec::new();
    for rest in minima {
        match found.iter_mut().find(|other| other.down.dot(rest.down) >= TIP.cos()) {
            Some(other) if rest.height < other.height => *other = rest,
            Some(_) => (),
            None => found.push(rest),
        }
    }
    found.sort_by(|a, b| a.height.total_cmp(&b.height));
    found
}

/// The direction reached by steps downhill from another one.
fn lowest_near(start: DVec3, height: impl Fn(DVec3) -> f64) -> DVec3 {
    let (mut best, mut lowest, mut step) = (start, height(start), STEPS[0]);
    while step > STEPS[1] {
        let (right, up) = best.any_orthonormal_pair();
        let turns = (0..N_TURNS).map(|turn| TAU * turn as f64 / N_TURNS as f64);
        let around = turns.map(|turn| (best + step * (turn.cos() * right + turn.sin() * up)).normalize());
        let next = around.map(|down| (down, height(down))).min_by(|a, b| a.1.total_cmp(&b.1));
        match next.filter(|(_, next)| *next < lowest) {
            Some(next) => (best, lowest) = next,
            None => step *= 0.5,
        }
    }
    best
}

/// The nearest pose, if one is near, in which the object lies on three points with its centre of mass above
/// them. A search downhill ends short of this pose or, where the object tips over an edge, between two such
/// poses.
fn on_three(near: DVec3, points: &[DVec3], height: impl Fn(DVec3) -> f64) -> Option<Rest> {
    let mut lowest = points.to_vec();
    lowest.sort_by(|a, b| b.dot(near).total_cmp(&a.dot(near)));
    lowest.truncate(N_LOWEST);
    let mut best: Option<Rest> = None;
    for (i, a) in lowest.iter().enumerate() {
        for (j, b) in lowest.iter().enumerate().skip(i + 1) {
            for c in &lowest[j + 1..] {
                let normal = (b - a).cross(c - a).normalize_or_zero();
                let down = normal * normal.dot(near).signum();
                let is_nearest = best.is_none_or(|best| near.dot(down) > near.dot(best.down));
                let rest = Rest { down, height: a.dot(down) };
                // Last, since it reads all points.
                let is_lowest = || height(down) <= rest.height * (1.0 + TOLERANCE);
                if down.dot(near) >= (2.0 * TIP).cos() && is_nearest && rest.is_on([a, b, c]) && is_lowest() {
                    best = Some(rest);
                }
            }
        }
    }
    best
}

impl Rest {
    /// Whether the centre of mass, the origin of three points on the plane, is above their triangle.
    fn is_on(&self, [a, b, c]: [&DVec3; 3]) -> bool {
        let foot = self.height * self.down;
        let turn = |from: &DVec3, to: &DVec3| (to - from).cross(foot - from).dot(self.down);
        let turns = [turn(a, b), turn(b, c), turn(c, a)];
        let tolerance = TOLERANCE * self.height.powi(2);
        turns.iter().all(|turn| *turn >= -tolerance) || turns.iter().all(|turn| *turn <= tolerance)
    }
}

/// The points, relative to the centre of mass, that are farthest in some direction: no other can touch the
/// plane. Points between two directions are left out; the height is off by less than a thousandth.
fn outermost(points: &[DVec3], center_of_mass: DVec3) -> Vec<DVec3> {
    let points: Vec<DVec3> = points.iter().map(|point| *point - center_of_mass).collect();
    let tree = Farthest::new(points.iter().copied());
    let farthest = |i: usize| tree.along(sphere::fibonacci(i, N_DIRECTIONS)).map(|(_, number)| number);
    let mut outermost: Vec<usize> = (0..N_DIRECTIONS).into_par_iter().filter_map(farthest).collect();
    outermost.sort_unstable();
    outermost.dedup();
    outermost.into_iter().map(|i| points[i]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Aabb;
    use crate::geometry::random::Random;

    /// The faces of the convex hull with the centre of mass above their plane, by trying all triples.
    fn by_faces(points: &[DVec3], center_of_mass: DVec3) -> Vec<DVec3> {
        let mut downs = Vec::new();
        for (i, a) in points.iter().enumerate() {
            for (j, b) in points.iter().enumerate().skip(i + 1) {
                for c in points.iter().skip(j + 1) {
                    let normal = (b - a).cross(c - a).normalize();
                    let outward = if normal.dot(a - center_of_mass) < 0.0 { -normal } else { normal };
                    let is_face = points.iter().all(|point| outward.dot(point - a) <= 1e-12);
                    let foot = center_of_mass + outward * outward.dot(a - center_of_mass);
                    let turn = |from: DVec3, to: DVec3| (to - from).cross(foot - from).dot(outward);
                    let turns = [turn(*a, *b), turn(*b, *c), turn(*c, *a)];
                    if is_face && (turns.iter().all(|t| *t > 0.0) || turns.iter().all(|t| *t < 0.0)) {
                        downs.push(outward);
                    }
                }
            }
        }
        downs
    }

    #[test]
    fn an_object_rests_on_the_faces_that_its_center_of_mass_is_above() {
        let mut random = Random::new(5, 0);
        for _ in 0..8 {
            let stretch = DVec3::new(0.03, 0.05, 0.08);
            let points: Vec<DVec3> = (0..9).map(|_| random.in_cube().normalize() * stretch).collect();
            let center = points.iter().sum::<DVec3>() / 9.0;
            let found = rests(&points, center);
            let faces = by_faces(&points, center);
            for face in &faces {
                let height = |down: DVec3| points.iter().map(|p| (p - center).dot(down)).fold(0.0, f64::max);
                let directions = (0..N_DIRECTIONS).map(|i| sphere::fibonacci(i, N_DIRECTIONS));
                let mut near = directions.filter(|down| down.dot(*face) >= TIP.cos());
                let tips_over = near.any(|down| height(down) < height(*face));
                // If two faces are nearer to each other than that, the lower one is found.
                let is_found = found.iter().any(|rest| rest.down.dot(*face) > TIP.cos());
                assert!(is_found || tips_over, "{face} of {found:?}");
            }
            for rest in &found {
                assert!(faces.iter().any(|face| face.dot(rest.down) > 0.999), "{rest:?} of {faces:?}");
            }
        }
    }

    #[test]
    fn a_brick_rests_on_six_sides() {
        let brick = Aabb { min: DVec3::ZERO, max: DVec3::new(0.1, 0.06, 0.04) };
        let found = rests(&brick.corners(), brick.center());
        let heights: Vec<f64> = found.iter().map(|rest| (1e4 * rest.height).round()).collect();
        assert_eq!(heights, [200.0, 200.0, 300.0, 300.0, 500.0, 500.0]);
        assert!(rests(&[], DVec3::ZERO).is_empty());
    }
}
