//! The measured surface, as planning and the final model read it.
//!
//! [`frame_points`] returns the measured points of a frame with normals and colours, [`downsample`] thins
//! them, and [`fit_normals`] smooths their normals. [`MeasuredCells`] reports the accuracy of the surface,
//! [`SurfaceLooks`] the number of looks at it.

mod cloud;
mod cloud_point;
mod looks;
mod measured_cells;
mod normals;
mod tangent_plane;

pub use cloud::{downsample, downsample_counted};
pub use cloud_point::{CloudPoint, frame_points};
pub use looks::{LooksGoal, SurfaceLooks};
pub use measured_cells::MeasuredCells;
pub use normals::fit_normals;
pub use tangent_plane::{TangentPlane, TangentPlanes};
