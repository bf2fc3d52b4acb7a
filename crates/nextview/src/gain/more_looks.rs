use super::seen_voxels::{caster, occupied_voxels};
use crate::geometry::Pose;
use crate::map::Snapshot;
use crate::sensor::{DepthRange, Intrinsics};
use crate::surface::SurfaceLooks;
use crate::visibility::RayCaster;

/// The number of occupied voxels at which a view adds one of the looks that they lack: it shows them well
/// enough, and from far enough beside all looks so far. Rays are two voxels apart: of a surface seen straight
/// on, every fourth voxel is counted.
#[derive(Debug)]
pub struct MoreLooks<'a> {
    snapshot: &'a Snapshot,
    caster: RayCaster<'a>,
    looks: &'a SurfaceLooks,
    intrinsics: Intrinsics,
}

impl<'a> MoreLooks<'a> {
    /// The gain for these looks, in the voxels that they were counted in, for a camera with these optics that
    /// measures these depths.
    pub fn new(
        snapshot: &'a Snapshot,
        intrinsics: &Intrinsics,
        depth_range: DepthRange,
        looks: &'a SurfaceLooks,
    ) -> Self {
        let caster = caster(snapshot, intrinsics, depth_range);
        Self { snapshot, caster, looks, intrinsics: *intrinsics }
    }

    /// The gain of a view, in voxels.
    pub fn gain(&self, world_from_camera: &Pose) -> f64 {
        let (lattice, block) = (self.snapshot.lattice(), self.snapshot.block());
        let camera = world_from_camera.translation();
        let center = |voxel: &u32| lattice.center(block.key(*voxel as usize));
        let lacks = |voxel: &u32| self.looks.lacks(center(voxel), camera, &self.intrinsics);
        occupied_voxels(&self.caster, world_from_camera).iter().filter(|voxel| lacks(voxel)).count() as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Cancel;
    use crate::geometry::{Aabb, Lattice, VoxelBlock};
    use crate::map::LogOdds;
    use crate::sensor::{DepthImage, Frame};
    use crate::surface::LooksGoal;
    use crate::view::look_at;
    use crate::visibility::{FreeSpace, RayEnd, Sight};
    use glam::{DVec2, DVec3, IVec3, UVec3};
    use std::collections::BTreeSet;

    const VOXEL: f64 = 0.01;

    /// A camera this many degrees beside the normal of a plate across the box.
    fn beside(degrees: f64) -> Pose {
        let (sin, cos) = degrees.to_radians().sin_cos();
        look_at(DVec3::new(cos, sin, 0.0) * 0.4, DVec3::ZERO).unwrap()
    }

    /// The plate's voxels are those of x = 0; in front of it (+x) all is free.
    fn plate() -> Snapshot {
        let block = VoxelBlock::new(IVec3::splat(-8), UVec3::splat(16)).unwrap();
        Snapshot::from_fn(Lattice::new(VOXEL).unwrap(), block, |key| match key.x {
            0 => Some(LogOdds(0.85)),
            1.. => Some(LogOdds(-0.4)),
            _ => None,
        })
    }

    /// An image of the plate.
    fn frame(pose: Pose) -> Frame {
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
    fn met(snapshot: &Snapshot, view: f64) -> Vec<DVec3> {
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

    /// The slow twin: of these voxels of the plate, which every camera in front of it shows.
    fn by_definition(goal: LooksGoal, taken: &[f64], view: f64, centers: &[DVec3]) -> usize {
        let direction = |degrees: f64, center: DVec3| beside(degrees).translation() - center;
        let gains = |center: &&DVec3| {
            let mut looks: Vec<f64> = Vec::new();
            for &degrees in taken.iter().chain([&view]) {
                let is_steep = direction(degrees, **center).angle_between(DVec3::X) < 60_f64.to_radians();
                let angle =
                    |other: &f64| direction(degrees, **center).angle_between(direction(*other, **center));
                if is_steep && looks.iter().all(|other| angle(other) >= goal.apart) {
                    looks.push(degrees);
                }
            }
            looks.len() <= goal.n && looks.last() == Some(&view)
        };
        centers.iter().filter(gains).count()
    }

    #[test]
    fn counts_voxels_that_a_view_would_add_a_look_to() {
        let (snapshot, camera) = (plate(), Intrinsics::d435i());
        let mut some_voxels = false;
        for (goal, taken) in [
            (LooksGoal::default(), vec![0.0]),
            (LooksGoal { n: 2, ..LooksGoal::default() }, vec![0.0, 30.0]),
            (LooksGoal::default(), vec![-40.0, 0.0, 3.0, 9.5, 50.0]),
            (LooksGoal { n: 20, apart: 0.4, ..LooksGoal::default() }, vec![-40.0, 0.0]),
        ] {
            let mut looks = SurfaceLooks::new(VOXEL, goal).unwrap();
            for &degrees in &taken {
                let bounds = Aabb::cube(DVec3::ZERO, 0.16);
                looks.add(&frame(beside(degrees)), bounds, &Cancel::default()).unwrap();
            }
            let gain = MoreLooks::new(&snapshot, &camera, DepthRange::default(), &looks);
            for view in [-70.0, -58.0, -30.0, -8.0, 8.5, 12.0, 25.0, 53.0] {
                let met = met(&snapshot, view);
                let (found, expected) = (gain.gain(&beside(view)), by_definition(goal, &taken, view, &met));
                assert_eq!(found, expected as f64, "{taken:?}, then {view}");
                some_voxels |= (1..met.len()).contains(&expected);
            }
        }
        assert!(some_voxels, "no view is a look at a part of the plate");
    }
}
