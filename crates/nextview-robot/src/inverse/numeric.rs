use super::descent::descend;
use crate::Arm;
use nextview::geometry::Pose;
use nextview::geometry::random::Random;

/// Number of random starts, as documented in [`Arm::inverse`].
const N_STARTS: usize = 50;
/// Maximum number of steps from each start; a successful one takes about ten.
const N_STEPS: usize = 100;

/// The solutions found by descent from random values and from the caller's reference values.
pub(super) fn search(arm: &Arm, base_from_flange: &Pose, near: Option<&[f64]>) -> Vec<Vec<f64>> {
    let mut random = Random::new(0, 0);
    let mut draw = |_| {
        let limits = arm.joints.iter().map(|joint| joint.limits);
        limits.map(|limits| random.range(limits.lower, limits.upper)).collect()
    };
    let starts: Vec<Vec<f64>> =
        near.map(<[f64]>::to_vec).into_iter().chain((0..N_STARTS).map(&mut draw)).collect();
    starts.into_iter().filter_map(|start| descend(arm, base_from_flange, start, N_STEPS, true)).collect()
}
