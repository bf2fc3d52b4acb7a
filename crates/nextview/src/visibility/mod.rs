//! Visibility from view candidates: the only place where planning rays are cast.
//!
//! Start with [`RayCaster`]: it sends the rays of a view through a dense [`Snapshot`](crate::map::Snapshot)
//! and returns one [`Ray`] after the other. The rays are evaluated elsewhere.

mod entries;
mod measured_parts;
mod packet;
mod pass_grid;
mod paths;
mod ray;
mod ray_caster;
mod ray_grid;
mod sight;
mod value_caster;
mod view_rays;

pub use measured_parts::MeasuredParts;
pub(crate) use paths::Paths;
pub use ray::{Crossing, Ray, RayEnd};
pub use ray_caster::RayCaster;
pub use ray_grid::{NO_VOXEL_MISSED, RayGrid};
pub use sight::{FreeSpace, Sight};
pub(crate) use value_caster::ValueCaster;
pub use view_rays::ViewRays;
