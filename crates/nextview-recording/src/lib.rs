//! Recorded depth images with camera poses, and optional colour, from files.
//!
//! Start with [`Recording::open`]: it recognises a folder in our own simple format, a folder of the TUM RGB-D
//! benchmark, and an `.mcap` file with ROS 2 messages. `docs/recorded.md` describes all three. [`ros`]
//! contains types that a node needs as well: images, optics and transforms of ROS 2. [`write_folder()`]
//! writes frames in our own format. Nothing here plans or maps.

mod color_file;
mod depth_png;
mod encode;
mod error;
mod folder;
mod frame;
#[cfg(fuzzing)]
pub mod fuzzing;
mod lens;
mod limits;
mod mcap;
mod open;
mod recording;
mod rigid;
pub mod ros;
mod text;
mod trajectory;
mod tum;
mod write_folder;

pub use color_file::decode_color;
pub use depth_png::decode_depth;
pub use encode::{encode_color, encode_depth, encode_mask};
pub use error::RecordingError;
pub use frame::RecordedFrame;
pub use recording::{PoseDirection, ReadOptions, Recording, Skipped};
pub use rigid::{FARTHEST_POSITION, checked_position, read_transform};
pub use write_folder::{NumberedFrame, intrinsics_text, write_folder};
