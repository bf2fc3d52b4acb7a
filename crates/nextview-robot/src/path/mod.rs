//! Collision-free paths of joint values, and their timing. Start with [`plan_path`].

mod joint_path;
mod line;
mod no_path;
mod plan;
mod shortcut;
mod timing;
mod tree;

pub use joint_path::JointPath;
pub use line::line_contact;
pub use no_path::NoPath;
pub use plan::{plan_path, plan_path_to_any};
pub use timing::{JointTrajectory, motion_time};
