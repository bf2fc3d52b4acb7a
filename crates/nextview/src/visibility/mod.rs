//! What a view candidate would see: the only place where planning rays are cast.
//!
//! Start with [`RayCaster`]: it sends the rays of a view through a dense [`Snapshot`](crate::map::Snapshot) and
//! hands out one [`Ray`] after the other. What the rays are worth is decided elsewhere.

mod packet;
mod pass_grid;
mod paths;
mod ray;
mod ray_caster;
mod ray_grid;
mod sight;
mod worth_caster;

pub(crate) use paths::Paths;
pub use ray::{Crossing, Ray, RayEnd};
pub use ray_caster::RayCaster;
pub use ray_grid::{NO_VOXEL_MISSED, RayGrid};
pub use sight::{FreeSpace, Sight};
pub(crate) use worth_caster::WorthCaster;

#[cfg(test)]
pub(crate) use packet::tests::archs;
