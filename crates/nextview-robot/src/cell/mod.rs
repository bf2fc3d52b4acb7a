//! An arm in its surroundings: its pose, its load, its obstacles.

mod mount;
mod robot_cell;

pub use mount::Mount;
pub use robot_cell::RobotCell;
