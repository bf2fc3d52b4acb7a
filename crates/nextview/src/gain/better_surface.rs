use super::seen_voxels::{caster, occupied_voxels};
use crate::Error;
use crate::checked::check_range;
use crate::geometry::Pose;
use crate::map::Snapshot;
use crate::sensor::{DepthRange, Intrinsics};
use crate::surface::MeasuredCells;
use crate::visibility::RayCaster;
use glam::DVec3;

/// How much a view improves measured surface towards a required accuracy: over the occupied voxels that it
/// shows and whose expected error is above the goal, the sum of the missing share that it adds, at most 1.
///
/// The accuracy of a voxel is the inverse of its variance, and looks add up: a voxel of error s lacks `1 /
/// goal^2 - 1 / s^2`, and a look of error l adds `1 / l^2`. Surfaces seen at more than 73 degrees from their
/// normal count nothing.
#[derive(Debug)]
pub struct BetterSurface<'a> {
    snapshot: &'a Snapshot,
    caster: RayCaster<'a>,
    measured: &'a MeasuredCells,
    /// Inverse variance of the goal, 1/m^2.
    wanted: f64,
    /// Focal length, pixels.
    focal: f64,
}

/// Cosine of the flattest angle of a look that counts: beyond it most pixels are lost.
const LEAST_COSINE: f64 = 0.3;

impl<'a> BetterSurface<'a> {
    /// Creates the gain for a goal (standard deviation, metres, positive), in the voxels in which surface was
    /// measured, for a camera with these optics and depths.
    pub fn new(
        snapshot: &'a Snapshot,
        intrinsics: &Intrinsics,
        depth_range: DepthRange,
        measured: &'a MeasuredCells,
        goal: f64,
    ) -> Result<Self, Error> {
        check_range("goal", goal, f64::MIN_POSITIVE..=f64::MAX, "a positive number of metres")?;
        let caster = caster(snapshot, intrinsics, depth_range);
        let focal = intrinsics.focal().x;
        Ok(Self { snapshot, caster, measured, wanted: goal.powi(-2), focal })
    }

    /// Returns the gain of a view, in voxels.
    pub fn gain(&self, world_from_camera: &Pose) -> f64 {
        let voxels = occupied_voxels(&self.caster, world_from_camera);
        voxels.into_iter().filter_map(|voxel| self.of_voxel(voxel as usize, world_from_camera)).sum()
    }

    /// The gain of a look at an occupied voxel; `None` if its accuracy is sufficient, or its surface unknown.
    fn of_voxel(&self, voxel: usize, world_from_camera: &Pose) -> Option<f64> {
        let (lattice, block) = (self.snapshot.lattice(), self.snapshot.block());
        let center = lattice.center(block.key(voxel));
        let (error, normal) = self.measured.surface_at(center)?;
        let lacks = self.wanted - error.powi(-2);
        (lacks > 0.0).then(|| (self.look(center, normal, world_from_camera) / lacks).min(1.0))
    }

    /// The inverse variance of a look at a surface, 1/m^2.
    fn look(&self, position: DVec3, normal: DVec3, world_from_camera: &Pose) -> f64 {
        let to_camera = world_from_camera.translation() - position;
        let cosine = to_camera.normalize().dot(normal);
        let depth = world_from_camera.inverse().transform_point(position).z;
        if cosine < LEAST_COSINE || depth <= 0.0 {
            return 0.0;
        }
        let error = self.measured.surface_error();
        let n = (self.snapshot.lattice().voxel_size() * self.focal / depth).powi(2) * cosine;
        1.0 / error.of_look(error.of_pixel(depth, cosine, self.focal), n)
    }
}
