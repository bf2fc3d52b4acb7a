//! A plate across a box, its images and its voxels: for tests.

use crate::geometry::{Lattice, Pose, VoxelBlock};
use crate::map::{LogOdds, Snapshot};
use crate::sensor::{DepthImage, Frame, Intrinsics};
use crate::view::look_at;
use crate::visibility::{FreeSpace, RayCaster, RayEnd, Sight};
use glam::{DVec2, DVec3, IVec3, UVec3};
use std::collections::BTreeSet;

/// Metres.
pub const VOXEL: f64 = 0.01;

/// A camera at this angle, degrees, to the normal of a plate across the box.
pub fn beside(degrees: f64) -> Pose {
    let (sin, cos) = degrees.to_radians().sin_cos();
    look_at(DVec3::new(cos, sin, 0.0) * 0.4, DVec3::ZERO).unwrap()
}

/// A snapshot of the plate, which fills x = 0; in front of it (+x) all is free.
pub fn plate() -> Snapshot {
    let block = VoxelBlock::new(IVec3::splat(-8), UVec3::splat(16)).unwrap();
    Snapshot::from_fn(Lattice::new(VOXEL).unwrap(), block, |key| match key.x {
        0 => Some(LogOdds(0.85)),
        1.. => Some(LogOdds(-0.4)),
        _ => None,
    })
}

/// An image of the plate.
pub fn frame(pose: Pose) -> Frame {
    let camera = Intrinsics::d435i();
    let depth = (0..camera.n_pixels() as u32).map(|i| {
        let pixel = DVec2::new((i % 640) as f64, (i / 640) as f64);
        let ray = pose.rotation() * camera.deproject(pixel).unwrap().extend(1.0);
        let depth = (0.5 * VOXEL - pose.translation().x) / ray.x;
        if depth > 0.0 { depth as f32 } else { f32::INFINITY }
    });
    let image = DepthImage::from_metres(640, 480, depth.collect()).unwrap();
    Frame::new(image, camera, pose, 2.0).unwrap()
}

/// The middles of the plate's voxels that rays of a view meet.
pub fn met(snapshot: &Snapshot, view: f64) -> Vec<DVec3> {
    let sight = Sight::endless(FreeSpace::Clear);
    let caster = RayCaster::new(snapshot, &Intrinsics::d435i(), 2.0, sight).unwrap();
    let mut voxels = BTreeSet::new();
    caster.cast(&beside(view), |ray| {
        if let RayEnd::Occupied(crossing) = ray.end {
            voxels.insert(crossing.voxel);
        }
    });
    let center = |voxel: u32| snapshot.lattice().center(snapshot.block().key(voxel as usize));
    voxels.into_iter().map(center).collect()
}
