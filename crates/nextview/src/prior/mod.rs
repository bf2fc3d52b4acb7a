//! A learned prior over the voxels that are not measured: the probable place of unseen surfaces.
//!
//! Start with [`SurfacePrior`]: it estimates, for every voxel in which an unseen piece of the object's
//! surface may lie, how likely a ray ends there and how likely a camera that looks there sees a new piece of
//! surface. Both are learned from simulated scans of random objects and a few meshes; the features they are
//! learned on mean the same for any object, pose and voxel size.

mod coarse;
mod features;
mod network;
mod surface_prior;

pub use coarse::coarse_enough;
pub use features::VoxelFeatures;
pub use network::Network;
pub use surface_prior::{SurfaceEstimate, SurfacePrior, ViewingClass};
