use super::pair::Pair;
use super::pose_prior::{PoseDeviation, PosePrior, difference};
use crate::geometry::{Pose, solve};
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
}

/// Derivatives of a residual vector by the rotation and by the translation of a view, or of the shared error.
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
        }
    }

    /// Adds the distance of a point of view `j` from the surface of view `i`.
    pub fn add_pair(&mut self, i: usize, j: usize, pair: &Pair, weight: f64) {
        let turn = (pair.point - self.center).cross(pair.normal) / self.radius;
        let along = [turn.x, turn.y, turn.z, pair.normal.x, pair.normal.y, pair.normal.z];
        self.add(&[(j, along), (i, along.map(|value| -value))], weight, pair.residual());
    }

    /// Adds the difference of the pose of a view from its mean, given its given pose. Errors of rotations are
    /// small: products of them are negligible.
    pub fn add_pose(&mut self, view: usize, pose: &Pose, given: &Pose, prior: &PosePrior) {
        let mean = prior.mean(view, given);
        let [turned, shifted] = difference(&mean, pose);
        let mean_from_world = mean.rotation_matrix().transpose();
        let turn = mean_from_world * self.radius.recip();
        // A turn w about the middle moves the camera by w x arm.
        let swing = turn * -cross_matrix(pose.translation() - self.center);
        let shared = (!prior.is_exact(view)).then(|| self.shared());
        let [shared_turn, shared_shift] = self.minus_shared();
        let by_shared = |derivatives| shared.map(|shared| (shared, derivatives));
        let PoseDeviation { position, rotation } = prior.deviation(view);
        self.add_vector((view, [turn, DMat3::ZERO]), by_shared(shared_turn), rotation, turned);
        self.add_vector((view, [swing, mean_from_world]), by_shared(shared_shift), position, shifted);
    }

    /// Adds the prior of the error that the given poses share.
    pub fn add_shared_error(&mut self, prior: &PosePrior) {
        let [turned, shifted] = difference(&prior.given_from_camera, &Pose::IDENTITY);
        let PoseDeviation { position, rotation } = prior.shared;
        let [turn, shift] = self.minus_shared();
        self.add_vector((self.shared(), turn), None, rotation, turned);
        self.add_vector((self.shared(), shift), None, position, shifted);
    }

    /// The number of the shared error among the unknowns.
    fn shared(&self) -> usize {
        self.gradient.len() / 6 - 1
    }

    /// Derivatives of a remaining rotation and of a remaining translation by those of the shared error.
    fn minus_shared(&self) -> [[DMat3; 2]; 2] {
        [[-DMat3::IDENTITY * self.radius.recip(), DMat3::ZERO], [DMat3::ZERO, -DMat3::IDENTITY]]
    }

    /// Adds a residual vector with this deviation per axis.
    fn add_vector(&mut self, by: ByUnknown, also_by: Option<ByUnknown>, deviation: f64, residual: DVec3) {
        for axis in 0..3 {
            let row = |(unknown, [turn, shift]): ByUnknown| {
                let (turn, shift) = (turn.row(axis), shift.row(axis));
                (unknown, [turn.x, turn.y, turn.z, shift.x, shift.y, shift.z])
            };
            let rows: Vec<_> = [by].into_iter().chain(also_by).map(row).collect();
            self.add(&rows, deviation.powi(-2), residual[axis]);
        }
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

    /// Returns the step to the minimum; `None` if the equations do not determine it.
    pub fn solve(self) -> Option<JointStep> {
        let n_views = self.shared();
        let solution = solve(self.squares, &self.gradient)?;
        let mut unknowns =
            solution.chunks(6).map(|step| [-DVec3::from_slice(step), -DVec3::from_slice(&step[3..])]);
        let moved = |[turn, shift]: [DVec3; 2]| (turn.length_squared() + shift.length_squared()).sqrt();
        let views = unknowns.clone().take(n_views);
        let size = views.clone().map(moved).fold(0.0, f64::max);
        let turned = |turn: DVec3| DQuat::from_scaled_axis(turn / self.radius);
        let motion = |[turn, shift]: [DVec3; 2]| {
            let turn = turned(turn);
            Pose::new(turn, shift + self.center - turn * self.center).ok()
        };
        let motions = views.map(motion).collect::<Option<Vec<_>>>()?;
        let [turn, shift] = unknowns.next_back()?;
        let of_shared = Pose::new(turned(turn), shift).ok()?;
        Some(JointStep { motions, of_shared, size })
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
                let step = equations.solve().unwrap();
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
    fn without_residuals_there_is_no_step() {
        assert!(JointEquations::new(2, [].iter()).solve().is_none());
    }
}
