//! Next-best-view planning: where should a depth camera look next, so that an unknown object is scanned
//! completely in as few views as possible?
//!
//! Start with [`session::Session`]: it takes depth frames and gives camera poses. The modules are layers, and each
//! imports only from those before it: [`geometry`], [`flow`] -> [`sensor`] -> [`map`] -> [`view`], [`model`], [`prior`],
//! [`registration`] -> [`visibility`], [`motion`] -> [`gain`] -> [`planner`] -> [`session`]. Afterwards, [`model`] makes a surface
//! of the frames. The library computes: it opens no file, prints nothing, reads no clock and holds no global state.
#![doc = include_str!("../../../docs/conventions.md")]

mod error;
pub mod flow;
pub mod gain;
pub mod geometry;
pub mod map;
pub mod model;
pub mod motion;
pub mod planner;
pub mod prior;
pub mod registration;
pub mod sensor;
pub mod session;
pub mod view;
pub mod visibility;

pub use error::Error;
