use glam::{DQuat, DVec3};
use nextview::geometry::Pose;

/// A moving joint: the link after it turns about an axis, or slides along it.
#[derive(Clone, Debug, PartialEq)]
pub struct Joint {
    /// Name, unique within the arm.
    pub name: String,
    /// The type of motion.
    pub kind: JointKind,
    /// The frame of the joint at value 0 in the frame of the link before it.
    pub parent_from_joint: Pose,
    /// The axis in the frame of the joint, of unit length.
    pub axis: DVec3,
    /// The limits of the joint.
    pub limits: JointLimits,
}

/// How a joint moves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum JointKind {
    /// Turns about its axis; values are in radians.
    Revolute,
    /// Slides along its axis; values are in metres.
    Prismatic,
}

/// The range, speed and acceleration of a joint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JointLimits {
    /// Lower limit, radians or metres.
    pub lower: f64,
    /// Upper limit, radians or metres, at least `lower`.
    pub upper: f64,
    /// Maximum speed, radians or metres per second, positive.
    pub velocity: f64,
    /// Maximum acceleration, radians or metres per second squared, positive. A URDF does not state it.
    pub acceleration: f64,
}

impl JointLimits {
    /// Whether a value is within the range.
    pub fn contains(&self, value: f64) -> bool {
        (self.lower..=self.upper).contains(&value)
    }
}

impl Joint {
    /// The frame of the link after the joint at this value, in the frame of the link before it.
    pub fn parent_from_child(&self, value: f64) -> Pose {
        let moved = match self.kind {
            JointKind::Revolute => Pose::new(DQuat::from_axis_angle(self.axis, value), DVec3::ZERO),
            JointKind::Prismatic => Pose::new(DQuat::IDENTITY, self.axis * value),
        };
        self.parent_from_joint * moved.expect("a joint's axis is of unit length and its value finite")
    }
}
