use super::pair::Pair;
use crate::geometry::{Eigen, Pose};
use glam::{DQuat, DVec3};

/// The least-squares problem of one step: the motion that brings the points closest to the planes.
///
/// A small motion rotates by w about the points' middle c and translates by t: a residual n (p - q) changes
/// by (w x (p - c)) n + t n. The unknowns are w times the points' root mean square distance from c, and t, so
/// all six are in metres.
#[derive(Clone, Copy, Debug)]
pub(super) struct NormalEquations {
    center: DVec3,
    radius: f64,
    /// Mean of the derivatives' outer products.
    squares: [[f64; 6]; 6],
    /// Mean of the derivatives times the residual.
    gradient: [f64; 6],
}

/// Directions with eigenvalues below this share of the largest are determined only by rounding.
const LEAST_SHARE: f64 = 1e-9;

impl NormalEquations {
    /// Returns the problem of these pairs; residuals above `scale` metres count less and less. `None` if
    /// there are no pairs, or if all points coincide.
    pub fn new(pairs: &[Pair], scale: f64) -> Option<Self> {
        let n = pairs.len() as f64;
        let center = pairs.iter().map(|pair| pair.point).sum::<DVec3>() / n;
        let spread = pairs.iter().map(|pair| pair.point.distance_squared(center)).sum::<f64>() / n;
        let radius = spread.sqrt();
        if pairs.is_empty() || radius == 0.0 {
            return None;
        }
        let (mut squares, mut gradient, mut total) = ([[0.0; 6]; 6], [0.0; 6], 0.0);
        for pair in pairs {
            let (weight, residual) = (pair.weight(scale), pair.residual());
            let turn = (pair.point - center).cross(pair.normal) / radius;
            let derivative = [turn.x, turn.y, turn.z, pair.normal.x, pair.normal.y, pair.normal.z];
            for i in 0..6 {
                (0..6).for_each(|j| squares[i][j] += weight * derivative[i] * derivative[j]);
                gradient[i] += weight * derivative[i] * residual;
            }
            total += weight;
        }
        squares.as_flattened_mut().iter_mut().chain(&mut gradient).for_each(|value| *value /= total);
        Some(Self { center, radius, squares, gradient })
    }

    /// Adds a penalty on rotation: `turned` is the rotation vector so far, and a turn counts like a residual
    /// of the turn times `arm` metres.
    pub fn with_turn_held(mut self, turned: DVec3, arm: f64) -> Self {
        let stiffness = (arm / self.radius).powi(2);
        for (i, turned) in turned.to_array().into_iter().enumerate() {
            self.squares[i][i] += stiffness;
            self.gradient[i] += stiffness * self.radius * turned;
        }
        self
    }

    /// Returns the smallest eigenvalue.
    pub fn stiffness(&self) -> f64 {
        let eigen = Eigen::of(self.squares);
        eigen.values[eigen.smallest()].clamp(0.0, 1.0)
    }

    /// Returns the solution and its size, metres. Nothing moves in directions that the surface does not
    /// determine, or with less stiffness than this.
    pub fn step(&self, min_stiffness: f64) -> (Pose, f64) {
        let eigen = Eigen::of(self.squares);
        let largest = eigen.values.iter().fold(0.0, |a: f64, b| a.max(*b));
        let mut step = [0.0; 6];
        for (value, vector) in eigen.values.iter().zip(&eigen.vectors) {
            if *value > (LEAST_SHARE * largest).max(min_stiffness) {
                let along = -dot(vector, &self.gradient) / value;
                (0..6).for_each(|i| step[i] += along * vector[i]);
            }
        }
        let [wx, wy, wz, tx, ty, tz] = step;
        let turn = DQuat::from_scaled_axis(DVec3::new(wx, wy, wz) / self.radius);
        let shift = DVec3::new(tx, ty, tz) + self.center - turn * self.center;
        let motion = Pose::new(turn, shift).expect("solutions of finite equations are finite");
        (motion, dot(&step, &step).sqrt())
    }
}

fn dot(a: &[f64; 6], b: &[f64; 6]) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::random::Random;

    /// Surface points with planes of these normals through them, then moved.
    fn pairs(motion: &Pose, point_and_normal: impl Fn(&mut Random) -> (DVec3, DVec3)) -> Vec<Pair> {
        let mut random = Random::new(1, 0);
        let mut pair = || {
            let (known, normal) = point_and_normal(&mut random);
            Pair { point: motion.transform_point(known), known, normal }
        };
        (0..200).map(|_| pair()).collect()
    }

    fn motion(size: f64) -> Pose {
        let turn = DQuat::from_scaled_axis(size * DVec3::new(1.0, -2.0, 3.0));
        Pose::new(turn, size * DVec3::new(0.3, 0.2, -0.1)).unwrap()
    }

    #[test]
    fn a_small_motion_is_undone_but_for_its_square() {
        for size in [1e-3, 1e-4] {
            let pairs = pairs(&motion(size), |random| {
                (DVec3::new(3.0, 1.0, 2.0) + random.in_cube(), random.in_cube().normalize())
            });
            let equations = NormalEquations::new(&pairs, 1.0).unwrap();
            let (step, moved) = equations.step(0.0);
            let rest = step * motion(size);
            let error = rest.transform_point(DVec3::new(3.0, 1.0, 2.0)).distance(DVec3::new(3.0, 1.0, 2.0));
            assert!(error < 30.0 * size * size && moved > size, "{error}");
            assert!(equations.stiffness() > 0.1, "{equations:?}");
        }
    }

    #[test]
    fn what_slides_has_no_stiffness_and_is_not_moved_along() {
        let plane = |random: &mut Random| (random.in_cube().with_z(0.0), DVec3::Z);
        let ball = |random: &mut Random| {
            let normal = random.in_cube().normalize();
            (normal + DVec3::X, normal)
        };
        let of_plane = NormalEquations::new(&pairs(&motion(1e-3), plane), 1.0).unwrap();
        let of_ball = NormalEquations::new(&pairs(&motion(1e-3), ball), 1.0).unwrap();
        assert!(of_plane.stiffness() < 1e-12 && of_ball.stiffness() < 1e-4, "{of_ball:?}");
        let shift = of_plane.step(0.0).0.translation();
        assert!(shift.truncate().length() < 1e-4, "up and down alone: {shift}");
    }

    #[test]
    fn what_is_held_loosely_moves_along_the_stiff_directions_alone() {
        // A plane with low waves along x, which hold it a little.
        let waves = |random: &mut Random| {
            let slope = 0.03 * (20.0 * random.unit()).sin();
            (random.in_cube().with_z(0.0), DVec3::new(-slope, 0.0, 1.0).normalize())
        };
        let equations = NormalEquations::new(&pairs(&motion(1e-3), waves), 1.0).unwrap();
        let [freely, held] = [0.0, 0.005].map(|least| equations.step(least).0.translation());
        assert!(freely.x.abs() > 1e-4 && held.x.abs() < 1e-5, "{freely} {held}");
        assert!((held.z - freely.z).abs() < 1e-5 && held.z.abs() > 5e-5, "{freely} {held}");
    }

    #[test]
    fn a_turn_that_nothing_holds_is_undone_and_one_that_the_surface_holds_hardly_changes() {
        let plane = |random: &mut Random| (random.in_cube().with_z(0.0), DVec3::Z);
        let all_around = |random: &mut Random| (random.in_cube(), random.in_cube().normalize());
        let turn = |equations: NormalEquations, turned| {
            equations.with_turn_held(turned, 0.05).step(1e-3).0.rotation().to_scaled_axis()
        };
        let of = |pairs: &[Pair]| NormalEquations::new(pairs, 1.0).unwrap();
        let turned = 0.1 * DVec3::Z;
        let loose = turn(of(&pairs(&Pose::IDENTITY, plane)), turned);
        assert!((loose + turned).length() < 1e-3, "{loose}");
        let held = turn(of(&pairs(&Pose::IDENTITY, all_around)), turned);
        assert!(held.length() < 0.1 * turned.length(), "{held}");
    }

    #[test]
    fn a_step_with_a_held_turn_is_the_minimum_of_what_is_summed_up_point_by_point() {
        let pairs = pairs(&motion(1e-3), |random| (random.in_cube(), random.in_cube().normalize()));
        let (scale, arm, turned) = (0.01, 0.2, DVec3::new(0.02, -0.01, 0.03));
        let equations = NormalEquations::new(&pairs, scale).unwrap().with_turn_held(turned, arm);
        let weights: f64 = pairs.iter().map(|pair| pair.weight(scale)).sum();
        let sum = |turn: DVec3, shift: DVec3| {
            let moved = |pair: &Pair| turn.cross(pair.point - equations.center) + shift;
            let squares = pairs.iter().map(|pair| {
                pair.weight(scale) * (pair.residual() + pair.normal.dot(moved(pair))).powi(2) / weights
            });
            squares.sum::<f64>() + arm.powi(2) * (turned + turn).length_squared()
        };
        let step = equations.step(0.0).0;
        let turn = step.rotation().to_scaled_axis();
        let shift = step.transform_point(equations.center) - equations.center;
        let least = sum(turn, shift);
        for axis in [DVec3::X, DVec3::Y, DVec3::Z, -DVec3::X, -DVec3::Y, -DVec3::Z] {
            assert!(sum(turn + 1e-4 * axis, shift) > least && sum(turn, shift + 1e-4 * axis) > least);
        }
    }

    #[test]
    fn nothing_and_a_single_point_are_no_problem() {
        assert!(NormalEquations::new(&[], 1.0).is_none());
        let lone = pairs(&Pose::IDENTITY, |_| (DVec3::X, DVec3::Z));
        assert!(NormalEquations::new(&lone, 1.0).is_none());
    }

    #[test]
    fn large_residuals_count_less() {
        let near = pairs(&motion(1e-4), |random| (random.in_cube(), random.in_cube().normalize()));
        let mut all = near.clone();
        all.extend(near.iter().take(40).map(|pair| Pair { known: pair.known + DVec3::Y, ..*pair }));
        let step =
            |pairs: &[Pair], scale| NormalEquations::new(pairs, scale).unwrap().step(0.0).0.translation();
        let expected = step(&near, 0.01);
        assert!(step(&all, 0.01).distance(expected) < 1e-4 && step(&all, 1e3).distance(expected) > 1e-2);
    }
}
