use crate::{Joint, JointKind};
use std::f64::consts::TAU;

/// Tolerance at which a value beyond a limit counts as at the limit.
const AT_LIMIT: f64 = 1e-9;

/// All equivalent values of a joint within its limits; at most three.
pub(super) fn values(joint: &Joint, value: f64) -> Vec<f64> {
    let limits = joint.limits;
    let clamp = |value: f64| value.clamp(limits.lower, limits.upper);
    if joint.kind == JointKind::Prismatic {
        return if (clamp(value) - value).abs() <= AT_LIMIT { vec![clamp(value)] } else { Vec::new() };
    }
    let middle = clamp(0.0);
    let (lower, upper) = (limits.lower.max(middle - TAU), limits.upper.min(middle + TAU));
    let first = value + ((lower - AT_LIMIT - value) / TAU).ceil() * TAU;
    let turned = (0..3).map(|turn| first + f64::from(turn) * TAU);
    turned.take_while(|value| *value <= upper + AT_LIMIT).map(clamp).collect()
}

/// All combinations of the joints' values.
pub(super) fn combinations(choices: &[Vec<f64>]) -> Vec<Vec<f64>> {
    choices.iter().fold(vec![Vec::new()], |begun, choice| {
        let longer = |values: &Vec<f64>| {
            let values = values.clone();
            choice.iter().map(move |value| values.iter().copied().chain([*value]).collect())
        };
        begun.iter().flat_map(longer).collect()
    })
}
