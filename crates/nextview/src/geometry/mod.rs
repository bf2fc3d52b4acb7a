//! Poses, boxes, the voxel lattice and exact voxel traversal.
//!
//! Start with [`Pose`] for cameras and [`Lattice`] for voxels. World frame: right-handed, z up, metres.
//! Camera frame: x right, y down, z forward. Nothing here knows about occupancy or views.

mod aabb;
mod lattice;
mod pose;
pub mod random;
pub mod sphere;
mod traversal;

pub use aabb::Aabb;
pub use lattice::{Lattice, VoxelBlock, VoxelKey};
pub use pose::Pose;
pub use traversal::SegmentWalk;
