use crate::{JointKind, JointLimits, Shape};
use glam::{DQuat, DVec3};
use nextview::geometry::Pose;

/// A URDF as written: valid elements, not yet a tree.
pub(super) struct Model {
    pub name: String,
    pub links: Vec<ModelLink>,
    pub joints: Vec<ModelJoint>,
}

pub(super) struct ModelLink {
    pub name: String,
    pub line: u32,
    pub shapes: Vec<Shape>,
}

pub(super) struct ModelJoint {
    pub name: String,
    pub line: u32,
    /// Names of links, not yet resolved.
    pub parent: String,
    pub child: String,
    pub parent_from_joint: Pose,
    pub motion: JointMotion,
}

/// The motion of a joint in a URDF.
pub(super) enum JointMotion {
    Fixed,
    Moves {
        kind: JointKind,
        axis: DVec3,
        limits: JointLimits,
    },
    /// Follows another joint, or moves in several directions; named as in the file.
    Unsupported(&'static str),
}

impl JointMotion {
    /// The frame after the joint relative to that before it, at the value nearest to 0.
    pub fn at_rest(&self) -> Pose {
        let Self::Moves { kind, axis, limits } = self else { return Pose::IDENTITY };
        let value = 0.0_f64.clamp(limits.lower, limits.upper);
        let (rotation, translation) = match kind {
            JointKind::Revolute => (DQuat::from_axis_angle(*axis, value), DVec3::ZERO),
            JointKind::Prismatic => (DQuat::IDENTITY, *axis * value),
        };
        Pose::new(rotation, translation).expect("the reader accepts only numbers of at most 1e6")
    }
}
