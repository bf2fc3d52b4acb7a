//! A depth camera that looks at a triangle mesh.
//!
//! Start with [`SimulatedCamera`]. It is exact, without noise or loss at silhouettes, unless it is given
//! [`Noise`](crate::noise::Noise).

mod capture;
mod chunk;
mod clip;
mod color;
mod depth_buffer;
mod draw_list;
mod locator;
mod look;
mod pixel_box;
mod polynomial;
mod projection;
mod raster;
mod room;
mod samples;
mod simulated_camera;
#[cfg(test)]
mod tests;

pub use capture::Capture;
pub use look::Look;
pub use simulated_camera::{Background, SimulatedCamera};
