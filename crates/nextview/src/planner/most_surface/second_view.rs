use crate::geometry::Aabb;
use crate::map::Snapshot;
use crate::planner::Situation;
use glam::{DVec3, Vec3Swizzles};

/// Weight of the distance from the first view: of the cosine between the directions to both.
const PER_COSINE: f64 = -0.24;

/// Weight of the area of the box's outline.
const PER_OUTLINE: f64 = 0.61;

/// Weight of the distance from the box, in longest sides of the box.
const PER_DISTANCE: f64 = 0.14;

/// Maximum distance that counts, in longest sides of the box: the regression has no views from farther away.
const FARTHEST: f64 = 2.5;

/// Returns, by view, its advantage as the second view, in shares of the largest gain, on top of its gain;
/// zeros unless exactly one view was taken. The box is that of the snapshot.
///
/// One view reveals so little of the far side that the views of largest gain are often those whose gain is
/// overestimated most. The typical gains of such views on other objects are a better guide: large from the
/// other side, from directions where the box looks large, and from farther away. The weights are a linear
/// regression of true gains on objects for development: `docs/planner.md`.
pub(super) fn advantages(situation: &Situation<'_>, snapshot: &Snapshot) -> Vec<f64> {
    let n_taken = situation.frames().len().max(situation.visited().len());
    let first = situation.camera_position().filter(|_| n_taken == 1);
    let Some(first) = first else { return vec![0.0; situation.views().len()] };
    let bounds = snapshot.lattice().bounds(&snapshot.block());
    let toward = |camera: DVec3| (camera - bounds.center()).normalize_or_zero();
    let advantage = |camera: DVec3| {
        let distance = camera.distance(bounds.center()) / bounds.longest_side();
        PER_COSINE * toward(camera).dot(toward(first))
            + PER_OUTLINE * outline(&bounds, toward(camera))
            + PER_DISTANCE * distance.min(FARTHEST)
    };
    situation.views().poses().iter().map(|pose| advantage(pose.translation())).collect()
}

/// The area of the box's outline as seen from far away in this direction, relative to the largest.
fn outline(bounds: &Aabb, direction: DVec3) -> f64 {
    let size = bounds.size();
    let faces = size.yzx() * size.zxy();
    faces.normalize().dot(direction.abs())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Cancel;
    use crate::geometry::{Lattice, VoxelBlock};
    use crate::sensor::Intrinsics;
    use crate::view::{ViewSpace, look_at};
    use glam::{IVec3, UVec3};

    #[test]
    fn distance_counts_up_to_a_limit() {
        let lattice = Lattice::new(0.01).unwrap();
        let block = VoxelBlock::new(IVec3::splat(-10), UVec3::splat(20)).unwrap();
        let snapshot = Snapshot::from_fn(lattice, block, |_| None);
        let poses = [-0.4, 0.4, 0.6, 50.0].map(|x| look_at(DVec3::new(x, 0.0, 0.0), DVec3::ZERO).unwrap());
        let views = ViewSpace::new(poses.to_vec()).unwrap();
        let (camera, cancel) = (Intrinsics::d435i(), Cancel::default());
        let before = Situation::new(&snapshot, &views, &camera, &cancel);
        let situation = before.with_visited(&[0]).unwrap();
        let [_, near, far, farther] = advantages(&situation, &snapshot)[..] else { panic!("four views") };
        assert!(near < far && (far - farther).abs() < 1e-12, "{near} {far} {farther}");
        let later = before.with_visited(&[0, 1]).unwrap();
        assert_eq!(advantages(&later, &snapshot), [0.0; 4]);
    }

    #[test]
    fn the_outline_of_a_box_is_that_of_its_visible_faces() {
        let bounds = Aabb { min: DVec3::ZERO, max: DVec3::new(1.0, 2.0, 3.0) };
        let largest = DVec3::new(6.0, 3.0, 2.0).length();
        for (direction, area) in [(DVec3::X, 6.0), (-DVec3::Y, 3.0), (DVec3::Z, 2.0)] {
            assert!((outline(&bounds, direction) - area / largest).abs() < 1e-12);
        }
        assert!((outline(&bounds, DVec3::new(-6.0, 3.0, 2.0) / largest) - 1.0).abs() < 1e-12);
    }
}
