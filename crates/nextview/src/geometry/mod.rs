//! Poses, boxes, planes, the voxel lattice and exact voxel traversal.
//!
//! Start with [`Pose`] for cameras and [`Lattice`] for voxels. World frame: right-handed, z up, metres.
//! Camera frame: x right, y down, z forward. Nothing here knows about occupancy or views.

mod aabb;
mod box_count;
mod box_tree;
mod cholesky;
mod eigen;
pub(crate) mod lanes;
mod lattice;
mod moments;
mod nearest_source;
mod plane;
mod plane_fit;
mod pose;
pub mod random;
mod segment_fan;

pub mod sphere;
mod traversal;

pub use aabb::Aabb;
pub(crate) use box_count::BoxCount;
pub(crate) use box_tree::{BoxTree, Search};
pub(crate) use cholesky::Cholesky;
pub(crate) use eigen::Eigen;
pub use lattice::{Lattice, VoxelBlock, VoxelKey, local_origin};
pub(crate) use moments::Moments;
pub(crate) use nearest_source::{Nearest, NearestSource};
pub use plane::Plane;
pub use plane_fit::{PlaneFit, fit_ground, fit_ground_near};
pub(crate) use plane_fit::{fit_ground_stated, fit_ground_unless};
pub use pose::Pose;
pub(crate) use pose::check_position;
pub(crate) use segment_fan::SegmentFan;

pub use traversal::SegmentWalk;
