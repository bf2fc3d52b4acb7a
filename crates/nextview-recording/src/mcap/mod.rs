//! ROS 2 messages in an MCAP file: the optics, images and poses of one camera.

mod cdr;
mod chunk;
mod cursor;
mod file;
#[cfg(fuzzing)]
pub(crate) mod fuzzing;
mod image;
mod messages;
mod poses;
mod topics;

pub(crate) use image::{ImagePlace, color, depth};
pub(crate) use topics::read;
