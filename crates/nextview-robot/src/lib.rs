//! Arms that hold a depth camera, or the object before one: kinematics, collisions, joint trajectories.
//!
//! Start with [`Arm`]. Joint values are in radians, or in metres where a joint slides. Nothing here plans
//! views or maps.

pub mod arm;
pub mod collision;
pub mod path;

pub use arm::{Arm, Joint, JointKind, JointLimits, Link, Shape, ShapeKind};
