//! A learned prior over the unmeasured voxels: the probable place of unseen surfaces.
//!
//! Start with [`SurfacePrior`]. For every voxel in which an unseen piece of the object's surface may lie, it
//! estimates how likely a ray ends there, and how likely a camera that looks there sees a new piece of
//! surface. Both are learned from simulated scans of random objects and a few meshes. The features have the
//! same meaning for any object, pose and voxel size.

mod coarse;
mod features;
mod network;
mod surface_prior;

pub use coarse::coarse_enough;
pub use features::VoxelFeatures;
pub use network::Network;
pub use surface_prior::{SurfaceEstimate, SurfacePrior, ViewingClass};
