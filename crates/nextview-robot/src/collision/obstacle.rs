use super::gjk;
use super::solid::{Placement, Solid};
use super::voxels::BlockedVoxels;
use crate::ShapeKind;
use glam::DVec3;
use nextview::geometry::{Plane, Pose};

/// An obstacle for an arm, in the frame of its base.
#[derive(Clone, Debug)]
pub struct Obstacle {
    /// Name for messages.
    pub name: String,
    /// Its shape.
    pub kind: ObstacleKind,
}

/// The shape of an obstacle.
#[derive(Clone, Debug)]
pub enum ObstacleKind {
    /// A convex solid: a box, a wall, a post.
    Solid {
        /// The frame of the solid in that of the base.
        base_from_shape: Pose,
        /// Its kind and size.
        kind: ShapeKind,
    },
    /// Everything below a plane: a table or the floor.
    Below(Plane),
    /// Blocked voxels of a grid.
    Voxels(BlockedVoxels),
}

/// An obstacle prepared for checking.
#[derive(Clone, Debug)]
pub(super) enum Barrier {
    Solid(Solid, Placement),
    Below(Plane),
    Voxels(BlockedVoxels),
}

impl From<ObstacleKind> for Barrier {
    fn from(kind: ObstacleKind) -> Self {
        match kind {
            ObstacleKind::Solid { base_from_shape, kind } => {
                let (solid, middle) = Solid::new(&kind);
                Self::Solid(solid, Placement::from(base_from_shape).moved(middle))
            }
            ObstacleKind::Below(plane) => Self::Below(plane),
            ObstacleKind::Voxels(voxels) => Self::Voxels(voxels),
        }
    }
}

impl Barrier {
    /// A lower bound on the distance of a solid: within 1e-4 of it, at least `limit`, or below `enough`.
    pub fn distance(&self, solid: &Solid, base_from_solid: &Placement, limit: f64, enough: f64) -> f64 {
        match self {
            Self::Solid(barrier, base_from_barrier) => {
                let barrier_from_solid = base_from_barrier.inverse_times(base_from_solid);
                solid_distance(barrier, solid, &barrier_from_solid, limit)
            }
            Self::Below(plane) => {
                let down = base_from_solid.rotation.transpose() * -plane.normal();
                let lowest: DVec3 =
                    base_from_solid.rotation * solid.support(down) + base_from_solid.translation;
                (plane.height(lowest) - solid.round()).max(0.0)
            }
            Self::Voxels(voxels) => voxels.distance(solid, base_from_solid, limit, enough),
        }
    }
}

/// A lower bound on the distance between two solids in metres: within 1e-4 of it, or at least `limit`.
/// Bounding spheres save most of the work.
pub(super) fn solid_distance(a: &Solid, b: &Solid, a_from_b: &Placement, limit: f64) -> f64 {
    let bound = a.outside(a_from_b.translation) - b.radius();
    if bound >= limit { bound } else { gjk::distance(a, b, a_from_b, limit) }
}
