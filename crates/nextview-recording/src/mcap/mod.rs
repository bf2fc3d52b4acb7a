//! ROS 2 messages in an MCAP file: the optics, depth images and poses of one camera.

mod cdr;
mod chunk;
mod cursor;
mod depth;
mod file;
mod messages;
mod topics;

pub(crate) use depth::depth;
pub(crate) use file::Place;
pub(crate) use topics::read;
