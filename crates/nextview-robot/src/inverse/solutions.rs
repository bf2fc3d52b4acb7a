use super::axis::SixAxes;
use super::closed_form::ClosedForm;
use super::descent::descend;
use super::{numeric, redundant, turns};
use crate::{Arm, JointKind};
use nextview::geometry::Pose;
use std::f64::consts::TAU;

/// Maximum number of steps after a closed form. Exact axes need none or one, calibrated ones near singular
/// poses many.
const N_POLISH: usize = 50;
/// Maximum joint difference between equal solutions: a double root is found twice.
const SAME: f64 = 1e-6;

/// All solutions in lexicographic order.
pub(super) fn all(arm: &Arm, base_from_flange: &Pose, near: Option<&[f64]>) -> Vec<Vec<f64>> {
    let accepted = |candidates| accept(arm, base_from_flange, candidates);
    match arm.n_joints() {
        6 => {
            if let Some(form) = SixAxes::of(arm, None).and_then(|axes| ClosedForm::of(&axes)) {
                let near = near.and_then(|near| near.try_into().ok());
                let angles = form.solve(base_from_flange, near);
                return accepted(angles.into_iter().map(|angles| angles.to_vec()).collect());
            }
        }
        7 => {
            if let Some(held) = redundant::held_joint(arm) {
                let sampled = |n| accepted(redundant::candidates(arm, held, base_from_flange, near, n));
                let found = sampled(redundant::N_SAMPLES);
                return if found.is_empty() { sampled(redundant::N_FINE_SAMPLES) } else { found };
            }
        }
        _ => {}
    }
    accepted(numeric::search(arm, base_from_flange, near))
}

/// Polishes candidates, and keeps those that reach the pose within the limits, with all their turns.
fn accept(arm: &Arm, base_from_flange: &Pose, candidates: Vec<Vec<f64>>) -> Vec<Vec<f64>> {
    let mut distinct: Vec<Vec<f64>> = Vec::new();
    let mut found = Vec::new();
    for candidate in candidates {
        let Some(values) = descend(arm, base_from_flange, candidate, N_POLISH, false) else { continue };
        let joints = arm.joints.iter().zip(&values);
        let choices: Vec<Vec<f64>> = joints.map(|(joint, value)| turns::values(joint, *value)).collect();
        if choices.iter().any(Vec::is_empty) || distinct.iter().any(|other| is_same(arm, other, &values)) {
            continue;
        }
        found.extend(turns::combinations(&choices));
        distinct.push(values);
    }
    found.sort_by(|a, b| a.partial_cmp(b).expect("values of joints are numbers"));
    found
}

/// Whether two solutions are equal up to full turns.
fn is_same(arm: &Arm, a: &[f64], b: &[f64]) -> bool {
    arm.joints.iter().zip(a.iter().zip(b)).all(|(joint, (a, b))| {
        let difference = a - b;
        let turns = if joint.kind == JointKind::Revolute { (difference / TAU).round() } else { 0.0 };
        (difference - turns * TAU).abs() < SAME
    })
}
