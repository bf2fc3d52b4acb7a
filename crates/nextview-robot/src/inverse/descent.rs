use super::turns;
use crate::{Arm, JointKind};
use glam::{DQuat, DVec3};
use nextview::geometry::Pose;

/// Maximum pose error of a solution in metres and radians.
pub(super) const TOLERANCE: f64 = 1e-6;
/// Error below which no step is taken, because of rounding.
const EXACT: f64 = 1e-11;
/// Damping of the first step, and the bound beyond which the search stops.
const FIRST_DAMPING: f64 = 1e-4;
const LAST_DAMPING: f64 = 1e4;

/// Maximum value in radians or metres; larger steps are rejected, because steps near a singular pose are
/// unbounded.
const FARTHEST: f64 = 1e6;

/// Pose error: metres and, as a vector along the axis, radians.
type PoseOffset = [f64; 6];

/// Descends from `values` towards a pose in at most `n_steps` steps of damped least squares
/// (Levenberg-Marquardt; Nakamura and Hanafusa 1986). Returns the values if they reach it.
pub(super) fn descend(
    arm: &Arm,
    target: &Pose,
    mut values: Vec<f64>,
    n_steps: usize,
    within_limits: bool,
) -> Option<Vec<f64>> {
    let mut error = error_of(arm, target, &values);
    let mut damping = FIRST_DAMPING;
    for _ in 0..n_steps {
        if norm(&error) < EXACT || damping > LAST_DAMPING {
            break;
        }
        let mut moved = values.clone();
        for (value, step) in moved.iter_mut().zip(step(arm, &values, &error, damping)) {
            *value += step;
        }
        if within_limits {
            for (value, joint) in moved.iter_mut().zip(&arm.joints) {
                let turned = turns::values(joint, *value).first().copied();
                *value = turned.unwrap_or(value.clamp(joint.limits.lower, joint.limits.upper));
            }
        }
        if !moved.iter().all(|value| value.abs() < FARTHEST) {
            damping *= 10.0;
            continue;
        }
        let new_error = error_of(arm, target, &moved);
        if norm(&new_error) < norm(&error) {
            (values, error, damping) = (moved, new_error, damping * 0.1);
        } else {
            damping *= 10.0;
        }
    }
    reaches(&error).then_some(values)
}

fn reaches(error: &PoseOffset) -> bool {
    let [x, y, z, a, b, c] = *error;
    DVec3::new(x, y, z).length() <= TOLERANCE && DVec3::new(a, b, c).length() <= TOLERANCE
}

fn norm(error: &PoseOffset) -> f64 {
    error.iter().map(|part| part * part).sum::<f64>().sqrt()
}

fn error_of(arm: &Arm, target: &Pose, values: &[f64]) -> PoseOffset {
    let reached = arm.forward(values);
    let offset = target.translation() - reached.translation();
    let turn = scaled_axis(target.rotation() * reached.rotation().conjugate());
    [offset.x, offset.y, offset.z, turn.x, turn.y, turn.z]
}

/// A rotation as axis times angle, by the shorter way, accurate for small angles.
fn scaled_axis(rotation: DQuat) -> DVec3 {
    let shorter = if rotation.w < 0.0 { -rotation } else { rotation };
    let sine = shorter.xyz().length();
    if sine < f64::MIN_POSITIVE { DVec3::ZERO } else { shorter.xyz() * (2.0 * sine.atan2(shorter.w) / sine) }
}

/// The step that reduces an error: J^T (J J^T + damping)^-1 error.
fn step(arm: &Arm, values: &[f64], error: &PoseOffset, damping: f64) -> Vec<f64> {
    let columns = jacobian(arm, values);
    let mut matrix = [[0.0; 6]; 6];
    for (row, line) in matrix.iter_mut().enumerate() {
        for (column, cell) in line.iter_mut().enumerate() {
            *cell = columns.iter().map(|joint| joint[row] * joint[column]).sum();
        }
        line[row] += damping * norm(error).clamp(1e-12, 1.0);
    }
    let weights = solve(matrix, *error);
    columns.iter().map(|joint| (0..6).map(|row| joint[row] * weights[row]).sum()).collect()
}

/// Motion of the flange by each joint.
fn jacobian(arm: &Arm, values: &[f64]) -> Vec<PoseOffset> {
    let base_from_links = arm.link_poses(values);
    let flange = (base_from_links[arm.n_joints()] * arm.last_link_from_flange).translation();
    let joints = arm.joints.iter().zip(&base_from_links[1..]);
    joints
        .map(|(joint, base_from_link)| {
            // Neither turning about an axis nor sliding along it changes its direction.
            let axis = base_from_link.rotation() * joint.axis;
            let (linear, angular) = match joint.kind {
                JointKind::Revolute => (axis.cross(flange - base_from_link.translation()), axis),
                JointKind::Prismatic => (axis, DVec3::ZERO),
            };
            [linear.x, linear.y, linear.z, angular.x, angular.y, angular.z]
        })
        .collect()
}

/// Solves a positive definite system by Cholesky decomposition.
fn solve(matrix: [[f64; 6]; 6], right: PoseOffset) -> PoseOffset {
    let mut lower = matrix;
    for row in 0..6 {
        for column in 0..=row {
            let known: f64 = (0..column).map(|k| lower[row][k] * lower[column][k]).sum();
            let rest = matrix[row][column] - known;
            // Damping keeps the diagonal positive, up to rounding.
            lower[row][column] =
                if row == column { rest.max(1e-30).sqrt() } else { rest / lower[column][column] };
        }
    }
    let mut solution = right;
    for row in 0..6 {
        let known: f64 = (0..row).map(|k| lower[row][k] * solution[k]).sum();
        solution[row] = (solution[row] - known) / lower[row][row];
    }
    for row in (0..6).rev() {
        let known: f64 = (row + 1..6).map(|k| lower[k][row] * solution[k]).sum();
        solution[row] = (solution[row] - known) / lower[row][row];
    }
    solution
}
