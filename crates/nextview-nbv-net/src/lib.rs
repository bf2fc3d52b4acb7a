//! NBV-Net (Mendoza, Vasquez-Gomez, Taud, Sucar & Reta, *Supervised learning of the next-best-view for 3D object
//! reconstruction*, Pattern Recognition Letters 2020): a 3D convolutional network that looks at what is known of the box
//! around an object and names one of 14 views.
//!
//! Start with the planner [`NbvNet`]; what it looks at is a [`Grid`], what it names one of the [`views`]. A crate of its own because of
//! the weights it carries, 3 MB. How they were learned is no part of it.

mod error;
mod grid;
mod network;
mod planner;
pub mod views;
mod weights;

pub use error::{Shape, WeightsError};
pub use grid::Grid;
pub use network::Network;
pub use planner::NbvNet;
