use super::pair::Pair;
use super::pose_prior::{PoseDeviation, PosePrior, difference};
use crate::geometry::{Cholesky, Pose};
use glam::{DMat3, DQuat, DVec3};

/// The normal equations of a step of the alignment of all frames.
///
/// The unknowns of a view are a rotation about the points' middle, times their radius, and a translation, in
/// the world frame: six numbers in metres. After those of all views come those of the error that the given
/// poses share: a rotation, times the same radius, and a translation, in the camera frame.
pub(super) struct JointEquations {
    center: DVec3,
    radius: f64,
    /// Row by row.
    squares: Vec<f64>,
    gradient: Vec<f64>,
    /// The own errors of the views that are not exact, and the shared error: three axes of rotation, radians,
    /// then three of position, metres.
    errors: Vec<[PoseError; 6]>,
}

/// An error of a given pose along or about an axis.
#[derive(Clone, Copy)]
struct PoseError {
    value: f64,
    /// By unknown, of a view and of the shared error.
    derivatives: [(usize, [f64; 6]); 2],
}

/// Derivatives of a vector by the rotation and by the translation of a view, or of the shared error.
type ByUnknown = (usize, [DMat3; 2]);

/// A step of the alignment of all frames.
pub(super) struct JointStep {
    /// By view, the motion of its camera in the world frame.
    pub motions: Vec<Pose>,
    /// The motion of the shared error, in the camera frame.
    pub of_shared: Pose,
    /// The largest motion of a view, at the points, metres.
    pub size: f64,
}

impl JointEquations {
    /// Returns the equations of so many views, without residuals. The pairs determine middle and radius.
    pub fn new<'a>(n_views: usize, pairs: impl Iterator<Item = &'a Pair> + Clone) -> Self {
        let n = pairs.clone().count().max(1) as f64;
        let center = pairs.clone().map(|pair| pair.point).sum::<DVec3>() / n;
        let spread = pairs.map(|pair| pair.point.distance_squared(center)).sum::<f64>() / n;
        let size = 6 * (n_views + 1);
        Self {
            center,
            radius: spread.sqrt().max(f64::MIN_POSITIVE.sqrt()),
            squares: vec![0.0; size * size],
            gradient: vec![0.0; size],
            errors: Vec::new(),
        }
    }

    /// Adds the distance of a point of view `j` from the surface of view `i`.
    pub fn add_pair(&mut self, i: usize, j: usize, pair: &Pair, weight: f64) {
        let turn = (pair.point - self.center).cross(pair.normal) / self.radius;
        let along = [turn.x, turn.y, turn.z, pair.normal.x, pair.normal.y, pair.normal.z];
        self.add(&[(j, along), (i, along.map(|value| -value))], weight, pair.residual());
    }

    /// Adds the own error of the given pose of a view. Errors of rotations are small: products of them are
    /// negligible.
    pub fn add_pose(&mut self, view: usize, pose: &Pose, given: &Pose, prior: &PosePrior) {
        let mean = prior.mean(view, given);
        let mean_from_world = mean.rotation_matrix().transpose();
        let turn = mean_from_world * self.radius.recip();
        // A turn w about the middle moves the camera by w x arm.
        let swing = turn * -cross_matrix(pose.translation() - self.center);
        let by_view = [[turn, DMat3::ZERO], [swing, mean_from_world]].map(|by| (view, by));
        let is_exact = prior.is_exact(view);
        let by_shared = self.by_shared(if is_exact { 0.0 } else { -1.0 });
        let errors = self.add_errors(difference(&mean, pose), [by_view, by_shared], prior.deviation(view));
        if !is_exact {
            self.errors.push(errors);
        }
    }

    /// Adds the prior of the error that the given poses share. It is the last to be added.
    pub fn add_shared_error(&mut self, prior: &PosePrior) {
        let value = difference(&Pose::IDENTITY, &prior.given_from_camera);
        let errors = self.add_errors(value, [self.by_shared(1.0), self.by_shared(0.0)], prior.shared);
        self.errors.push(errors);
    }

    /// The number of the shared error among the unknowns.
    fn shared(&self) -> usize {
        self.gradient.len() / 6 - 1
    }

    /// The derivatives of a rotation and of a position in the camera frame by the shared error.
    fn by_shared(&self, sign: f64) -> [ByUnknown; 2] {
        let unit = DMat3::IDENTITY * sign;
        [[unit * self.radius.recip(), DMat3::ZERO], [DMat3::ZERO, unit]].map(|by| (self.shared(), by))
    }

    /// Adds the errors of a rotation and of a position, with their derivatives by two unknowns, as residuals
    /// with this deviation.
    fn add_errors(
        &mut self,
        values: [DVec3; 2],
        by: [[ByUnknown; 2]; 2],
        deviation: PoseDeviation,
    ) -> [PoseError; 6] {
        let weights = [deviation.rotation, deviation.position].map(|deviation| deviation.powi(-2));
        std::array::from_fn(|i| {
            let (kind, axis) = (i / 3, i % 3);
            let derivatives = by.map(|by| {
                let (unknown, [turn, shift]) = by[kind];
                let (turn, shift) = (turn.row(axis), shift.row(axis));
                (unknown, [turn.x, turn.y, turn.z, shift.x, shift.y, shift.z])
            });
            let error = PoseError { value: values[kind][axis], derivatives };
            self.add(&derivatives, weights[kind], error.value);
            error
        })
    }

    /// Adds a residual with its derivatives by the six unknowns of views.
    fn add(&mut self, derivatives: &[(usize, [f64; 6])], weight: f64, residual: f64) {
        let size = self.gradient.len();
        for (view, along) in derivatives {
            for (row, value) in (6 * view..).zip(along) {
                self.gradient[row] += weight * value * residual;
                for (other, other_along) in derivatives {
                    let at = row * size + 6 * other;
                    for (square, other_value) in self.squares[at..at + 6].iter_mut().zip(other_along) {
                        *square += weight * value * other_value;
                    }
                }
            }
        }
    }

    /// Factors the equations; `None` if they do not determine all unknowns.
    pub fn factored(self) -> Option<FactoredEquations> {
        let factor = Cholesky::of(self.squares.clone(), self.gradient.len())?;
        Some(FactoredEquations { equations: self, factor })
    }
}

/// Equations whose solution and its uncertainty are known.
pub(super) struct FactoredEquations {
    equations: JointEquations,
    factor: Cholesky,
}

impl FactoredEquations {
    /// Returns the step to the minimum; `None` if it leads out of reach.
    pub fn step(&self) -> Option<JointStep> {
        let &JointEquations { center, radius, ref gradient, .. } = &self.equations;
        let solution = self.factor.solve(gradient);
        let unknowns: Vec<_> = solution
            .chunks(6)
            .map(|step| [-DVec3::from_slice(step), -DVec3::from_slice(&step[3..])])
            .collect();
        let (&[turn, shift], views) = unknowns.split_last()?;
        let moved = |[turn, shift]: &[DVec3; 2]| (turn.length_squared() + shift.length_squared()).sqrt();
        let size = views.iter().map(moved).fold(0.0, f64::max);
        let turned = |turn: DVec3| DQuat::from_scaled_axis(turn / radius);
        let motion = |&[turn, shift]: &[DVec3; 2]| {
            let turn = turned(turn);
            Pose::new(turn, shift + center - turn * center).ok()
        };
        let motions = views.iter().map(motion).collect::<Option<Vec<_>>>()?;
        let of_shared = Pose::new(turned(turn), shift).ok()?;
        Some(JointStep { motions, of_shared, size })
    }

    /// Returns the most likely deviation of the views' own errors: the mean of their squares, each with the
    /// variance of what is known of it (expectation maximisation). `None` if all views are exact.
    pub fn own_deviation(&self) -> Option<PoseDeviation> {
        let (_, own) = self.equations.errors.split_last()?;
        (!own.is_empty()).then(|| {
            let square = |error: &PoseError| error.value.powi(2) + self.variance(error);
            let root_mean = |axes: std::ops::Range<usize>| {
                let squares = own.iter().flat_map(|errors| &errors[axes.clone()]).map(square);
                (squares.sum::<f64>() / (3 * own.len()) as f64).sqrt()
            };
            PoseDeviation { rotation: root_mean(0..3), position: root_mean(3..6) }
        })
    }

    /// Returns the deviation of what is known of the shared error: the root of the sum over three axes.
    pub fn shared_deviation(&self) -> PoseDeviation {
        let root = |errors: &[PoseError]| errors.iter().map(|error| self.variance(error)).sum::<f64>().sqrt();
        match self.equations.errors.last() {
            Some(errors) => PoseDeviation { rotation: root(&errors[..3]), position: root(&errors[3..]) },
            None => PoseDeviation { rotation: f64::INFINITY, position: f64::INFINITY },
        }
    }

    /// The variance of what is known of an error.
    fn variance(&self, error: &PoseError) -> f64 {
        let mut derivatives = vec![0.0; self.equations.gradient.len()];
        for (unknown, along) in &error.derivatives {
            let at = 6 * unknown;
            derivatives[at..at + 6].iter_mut().zip(along).for_each(|(sum, value)| *sum += value);
        }
        self.factor.variance(&derivatives)
    }
}

/// Returns the matrix of the cross product with a vector from the left.
fn cross_matrix(v: DVec3) -> DMat3 {
    DMat3::from_cols(DVec3::new(0.0, v.z, -v.y), DVec3::new(-v.z, 0.0, v.x), DVec3::new(v.y, -v.x, 0.0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::random::Random;
    use crate::registration::{GivenPoses, RegistrationConfig};

    /// A pair in the frames of its views.
    struct FixedPair {
        views: [usize; 2],
        /// Of views 0 and 1.
        points: [DVec3; 2],
        /// In the frame of view 0.
        normal: DVec3,
    }

    impl FixedPair {
        fn placed(&self, poses: &[Pose]) -> Pair {
            let [i, j] = self.views;
            Pair {
                point: poses[j].transform_point(self.points[1]),
                known: poses[i].transform_point(self.points[0]),
                normal: poses[i].rotation() * self.normal,
            }
        }
    }

    const WEIGHT: f64 = 4e5;

    /// The slow twin: the sum that is minimised, term by term.
    fn cost(poses: &[Pose], given: &[Pose], pairs: &[FixedPair], prior: &PosePrior) -> f64 {
        let of_pairs = pairs.iter().map(|pair| WEIGHT * pair.placed(poses).residual().powi(2)).sum::<f64>();
        let of_difference = |from: &Pose, to: &Pose, deviation: PoseDeviation| {
            let [turned, shifted] = difference(from, to);
            (turned / deviation.rotation).length_squared() + (shifted / deviation.position).length_squared()
        };
        let of_poses = (0..poses.len())
            .map(|i| of_difference(&prior.mean(i, &given[i]), &poses[i], prior.deviation(i)))
            .sum::<f64>();
        of_pairs + of_poses + of_difference(&Pose::IDENTITY, &prior.given_from_camera, prior.shared)
    }

    fn small(size: f64, random: &mut Random) -> Pose {
        let turn = DQuat::from_scaled_axis(size * random.in_cube());
        Pose::new(turn, size * random.in_cube()).unwrap()
    }

    #[test]
    fn steps_lead_to_the_minimum_of_what_is_summed_up_term_by_term() {
        let mut random = Random::new(4, 0);
        for given_poses in [GivenPoses::Independent, GivenPoses::FirstIsRight, GivenPoses::Tracked] {
            let config = RegistrationConfig { given_poses, ..RegistrationConfig::default() };
            let mut prior = PosePrior::new(&config);
            let truths: Vec<_> = (0..4).map(|_| small(0.5, &mut random)).collect();
            let given: Vec<_> = truths.iter().map(|pose| *pose * small(0.01, &mut random)).collect();
            let pair = |random: &mut Random| {
                let (i, point) = (random.index(4), 0.1 * random.in_cube());
                let views = [i, (i + 1 + random.index(3)) % 4];
                let points = views.map(|view| truths[view].inverse().transform_point(point));
                FixedPair { views, points, normal: random.in_cube().normalize() }
            };
            let pairs: Vec<_> = (0..15).map(|_| pair(&mut random)).collect();
            let mut poses = given.clone();
            for _ in 0..20 {
                let placed: Vec<_> = pairs.iter().map(|pair| pair.placed(&poses)).collect();
                let mut equations = JointEquations::new(4, placed.iter());
                for (pair, placed) in pairs.iter().zip(&placed) {
                    equations.add_pair(pair.views[0], pair.views[1], placed, WEIGHT);
                }
                (0..4).for_each(|i| equations.add_pose(i, &poses[i], &given[i], &prior));
                equations.add_shared_error(&prior);
                let step = equations.factored().unwrap().step().unwrap();
                poses.iter_mut().zip(&step.motions).for_each(|(pose, motion)| *pose = *motion * *pose);
                prior.given_from_camera = prior.given_from_camera * step.of_shared;
            }
            let least = cost(&poses, &given, &pairs, &prior);
            for view in 0..5 {
                for _ in 0..20 {
                    let motion = small(1e-3, &mut random);
                    let (mut near, mut near_prior) = (poses.clone(), prior);
                    match near.get_mut(view) {
                        Some(pose) => *pose = motion * *pose,
                        None => near_prior.given_from_camera = prior.given_from_camera * motion,
                    }
                    let cost = cost(&near, &given, &pairs, &near_prior);
                    assert!(cost > least, "{given_poses:?}, view {view}: {cost} {least}");
                }
            }
        }
    }

    #[test]
    fn without_residuals_nothing_is_determined() {
        assert!(JointEquations::new(2, [].iter()).factored().is_none());
    }
}
