//! Arms that hold a depth camera, or the object before one: kinematics, collisions, joint trajectories.
//!
//! Start with [`Arm`], or with [`RobotCell`] for one in its surroundings. Joint values are in radians, or in
//! metres where a joint slides. Nothing here plans views or maps.

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
