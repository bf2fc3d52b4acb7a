//! NBV-Net (Mendoza, Vasquez-Gomez, Taud, Sucar & Reta, *Supervised learning of the next-best-view for 3D
//! object reconstruction*, Pattern Recognition Letters 2020): a 3D convolutional network that takes the known
//! state of the box around an object and chooses one of 14 views.
//!
//! Start with the planner [`NbvNet`]; its input is a [`Grid`](crate::Grid), its output one of the [`views`].
//! `docs/methods/nbv-net.md` describes the training of its weights.

mod network;
mod planner;
pub mod views;

pub use network::Network;
#[cfg(test)]
pub(crate) use network::layout;
pub use planner::NbvNet;
