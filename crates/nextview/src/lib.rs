//! Next-best-view planning: where should a depth camera look next, so that an unknown object is scanned
//! completely in as few views as possible?
#![doc = include_str!("../../../docs/conventions.md")]

mod error;
pub mod flow;
pub mod geometry;
pub mod map;
pub mod sensor;

pub use error::Error;
