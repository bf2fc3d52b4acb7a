//! Robot arms that hold a depth camera or its object: kinematics, collisions, joint trajectories.
//!
//! Start with [`Arm`], or with [`RobotCell`] for an arm in its surroundings. Joint values are in radians, or
//! in metres for sliding joints. Nothing here plans views or maps.

pub mod arm;
pub mod cell;
pub mod collision;
pub mod inverse;
pub mod path;
pub mod presets;
pub mod urdf;

pub use arm::{Arm, Joint, JointKind, JointLimits, Link, Shape, ShapeKind};
pub use cell::{Mount, RobotCell};
pub use urdf::UrdfOptions;
