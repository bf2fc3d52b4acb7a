//! Maximum motion of links by each joint.

use super::solid::{Placement, Solid};
use crate::{Arm, Joint, JointKind};
use glam::DVec3;

/// For each joint, the maximum motion of any point of these solids in metres per radian or metre, for any
/// values of the other joints. The solids are on a link, in its frame.
///
/// A turning joint moves a point in proportion to its distance from the axis. The path from the axis to the
/// point follows the frames of the joints in between. The first part of the path does not depend on joint
/// values: only its component across the axis counts. The other parts count in full.
pub(super) fn sweeps(arm: &Arm, link: usize, solids: &[(Solid, Placement)]) -> Vec<f64> {
    let corners: Vec<DVec3> = solids
        .iter()
        .flat_map(|(solid, placement)| solid.corners().map(|corner| placement.moved(corner).translation))
        .collect();
    let farthest = |size: &dyn Fn(DVec3) -> f64| corners.iter().map(|p| size(*p)).fold(0.0, f64::max);
    let mut sweeps = vec![0.0; arm.n_joints()];
    // Maximum distance of the points from the frame of the next joint.
    let mut reach = 0.0;
    for (i, joint) in arm.joints[..link].iter().enumerate().rev() {
        let across = |point: DVec3| (point - joint.axis * joint.axis.dot(point)).length();
        let (aside, far) = match arm.joints[..link].get(i + 1) {
            None => (farthest(&across), farthest(&DVec3::length)),
            Some(next) => {
                let at = next.parent_from_joint.translation();
                (across(at) + reach + travel(next), at.length() + reach + travel(next))
            }
        };
        sweeps[i] = if joint.kind == JointKind::Revolute { aside } else { 1.0 };
        reach = far;
    }
    sweeps
}

/// Maximum travel of a joint from its value 0 in metres.
fn travel(joint: &Joint) -> f64 {
    match joint.kind {
        JointKind::Revolute => 0.0,
        JointKind::Prismatic => joint.limits.lower.abs().max(joint.limits.upper.abs()),
    }
}
