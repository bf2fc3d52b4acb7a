use super::{Crossing, RayCaster, RayEnd};
use crate::geometry::Pose;
use crate::{Cancel, Cancelled};

/// All rays of a view as arrays, one ray after the other.
#[derive(Clone, Debug, PartialEq)]
pub struct ViewRays {
    /// The crossings of all rays.
    pub crossings: Vec<Crossing>,
    /// Number of crossings before those of each ray, and finally of all rays: one more than there are rays.
    pub offsets: Vec<usize>,
    /// How each ray ends.
    pub ends: Vec<RayEnd>,
}

impl RayCaster<'_> {
    /// Returns the rays of a view, in the order of [`cast`](Self::cast).
    ///
    /// ```
    /// # use glam::{DVec3, IVec3, UVec3};
    /// # use nextview::{Cancel, map::Snapshot, sensor::Intrinsics, view::look_at};
    /// # use nextview::geometry::{Lattice, VoxelBlock};
    /// use nextview::visibility::{FreeSpace, RayCaster};
    ///
    /// # let block = VoxelBlock::new(IVec3::splat(-4), UVec3::splat(8)).unwrap();
    /// # let unknown = Snapshot::from_fn(Lattice::new(0.01).unwrap(), block, |_| None);
    /// let caster = RayCaster::new(&unknown, &Intrinsics::d435i(), 2.0, FreeSpace::Clear).unwrap();
    /// let rays = caster.rays(&look_at(DVec3::X, DVec3::ZERO).unwrap(), &Cancel::default()).unwrap();
    /// assert_eq!(rays.offsets.len(), rays.ends.len() + 1);
    /// assert_eq!(rays.crossings[rays.offsets[1]].visibility, 1.0, "the second ray begins there");
    /// ```
    pub fn rays(&self, world_from_camera: &Pose, cancel: &Cancel) -> Result<ViewRays, Cancelled> {
        let mut rays = ViewRays { crossings: Vec::new(), offsets: vec![0], ends: Vec::new() };
        self.try_cast(world_from_camera, |ray| {
            rays.crossings.extend_from_slice(ray.crossings);
            rays.offsets.push(rays.crossings.len());
            rays.ends.push(ray.end);
            cancel.check()
        })?;
        Ok(rays)
    }
}
