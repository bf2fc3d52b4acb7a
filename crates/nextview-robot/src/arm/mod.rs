//! A serial arm: joints, links and forward kinematics.

mod joint;
mod link;
mod serial;

pub use joint::{Joint, JointKind, JointLimits};
pub use link::{Link, Shape, ShapeKind};
pub use serial::Arm;
