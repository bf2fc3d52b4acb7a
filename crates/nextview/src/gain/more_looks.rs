use super::seen_voxels::{caster, occupied_voxels};
use crate::geometry::Pose;
use crate::map::Snapshot;
use crate::sensor::{DepthRange, Intrinsics};
use crate::surface::SurfaceLooks;
use crate::visibility::RayCaster;

/// The number of occupied voxels at which a view adds one of the looks that they lack: it shows them well
/// enough, and from far enough away from all looks so far. Rays are two voxels apart: of a surface seen
/// straight on, every fourth voxel is counted.
#[derive(Debug)]
pub struct MoreLooks<'a> {
    snapshot: &'a Snapshot,
    caster: RayCaster<'a>,
    looks: &'a SurfaceLooks,
    intrinsics: Intrinsics,
}

impl<'a> MoreLooks<'a> {
    /// Creates the gain for these looks, in the voxels in which they were counted, for a camera with these
    /// optics and depths.
    pub fn new(
        snapshot: &'a Snapshot,
        intrinsics: &Intrinsics,
        depth_range: DepthRange,
        looks: &'a SurfaceLooks,
    ) -> Self {
        let caster = caster(snapshot, intrinsics, depth_range);
        Self { snapshot, caster, looks, intrinsics: *intrinsics }
    }

    /// Returns the gain of a view, in voxels.
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
    use super::super::plate::{VOXEL, beside, frame, met, plate};
    use super::*;
    use crate::Cancel;
    use crate::geometry::Aabb;
    use crate::surface::LooksGoal;
    use glam::DVec3;

    /// The slow twin: the gain of these voxels of the plate, all of which every camera in front of it shows.
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
