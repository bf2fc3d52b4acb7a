//! NBV regression (Vasquez-Gomez, Troncoso, Becerra, Sucar & Murrieta-Cid, *Next-best-view regression using a
//! 3D convolutional neural network*, Machine Vision and Applications 2021): a 3D convolutional network that
//! takes the known state of the box around an object and returns any direction for the next view.
//!
//! Start with the planner [`NbvRegression`]; its input is a [`Grid`](crate::Grid). The architecture is ours;
//! `docs/methods/nbv-regression.md` gives the reasons, and describes the training of the weights.

mod network;
mod planner;

pub use network::Network;
#[cfg(test)]
pub(crate) use network::layout;
pub use planner::NbvRegression;
