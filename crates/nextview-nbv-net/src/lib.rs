//! NBV-Net (Mendoza, Vasquez-Gomez, Taud, Sucar & Reta, *Supervised learning of the next-best-view for 3D object
//! reconstruction*, Pattern Recognition Letters 2020): a 3D convolutional network that looks at what is known of the box
//! around an object and names one of 14 views.
//!
//! A crate of its own because of the weights it carries.

mod grid;
pub mod views;

pub use grid::Grid;
