use super::axis::SixAxes;
use super::closed_form::ClosedForm;
use crate::Arm;
use nextview::geometry::Pose;

/// Number of values tried for the held joint.
pub(super) const N_SAMPLES: usize = 64;
/// Number of values tried if none of those [`N_SAMPLES`] values has a solution.
pub(super) const N_FINE_SAMPLES: usize = 1024;
/// Share of its range at which a joint is held to examine the others: an arbitrary, generic position.
const LOOK: f64 = 0.3819;

/// The last joint of a seven-joint arm that can be held to leave a closed form for the others.
pub(super) fn held_joint(arm: &Arm) -> Option<usize> {
    (0..7).rev().find(|&joint| {
        let limits = arm.joints[joint].limits;
        let value = limits.lower + LOOK * (limits.upper - limits.lower);
        SixAxes::of(arm, Some((joint, value))).is_some_and(|axes| ClosedForm::of(&axes).is_some())
    })
}

/// Candidates for evenly spaced values of the held joint, and for the caller's reference value.
pub(super) fn candidates(
    arm: &Arm,
    held: usize,
    base_from_flange: &Pose,
    near: Option<&[f64]>,
    n_samples: usize,
) -> Vec<Vec<f64>> {
    let limits = arm.joints[held].limits;
    let share = |sample: usize| (sample as f64 + 0.5) / n_samples as f64;
    let samples = (0..n_samples).map(|sample| limits.lower + share(sample) * (limits.upper - limits.lower));
    let near_others: Option<[f64; 6]> = near.and_then(|near| {
        let others = near.iter().enumerate().filter(|(joint, _)| *joint != held);
        others.map(|(_, value)| *value).collect::<Vec<_>>().try_into().ok()
    });
    let mut candidates = Vec::new();
    for value in near.map(|near| near[held]).into_iter().chain(samples) {
        let form = SixAxes::of(arm, Some((held, value))).and_then(|axes| ClosedForm::of(&axes));
        let angles = form.map_or_else(Vec::new, |form| form.solve(base_from_flange, near_others));
        candidates.extend(angles.into_iter().map(|angles| {
            let mut values = angles.to_vec();
            values.insert(held, value);
            values
        }));
    }
    candidates
}
