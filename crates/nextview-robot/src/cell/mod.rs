//! An arm in its surroundings: where it stands, what it carries, what it must not touch.

mod mount;
mod robot_cell;

pub use mount::Mount;
pub use robot_cell::RobotCell;
