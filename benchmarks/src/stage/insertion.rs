use super::timed_stage::{Stage, TimedWork, name_of};
use crate::workload::{N_IMAGES, Set, Workload, block, empty_map};
use nextview::geometry::Aabb;
use nextview::map::{Integration, RayRule};
use nextview::sensor::{Frame, Intrinsics};
use nextview_sim::camera::{Background, SimulatedCamera};
use std::hint::black_box;

/// The voxels that a stage may write.
#[derive(Clone, Copy)]
enum Space {
    /// The voxels of the box around the object.
    Box,
    /// All voxels.
    Unbounded,
}

/// Ten scans into an empty map, and a dense copy of it.
pub(super) fn stages() -> Vec<Stage> {
    use RayRule::{EveryPoint, OnePerEndVoxel};
    use Set::{A, B};
    use Space::{Box, Unbounded};
    let fine = &[0.01, 0.005, 0.002, 0.001][..];
    let coarse = &fine[..2];
    let points = [
        ("insertion A; per end voxel", A, OnePerEndVoxel, Box, fine),
        ("insertion A; per end voxel; unbounded", A, OnePerEndVoxel, Unbounded, fine),
        ("insertion A; every point", A, EveryPoint, Box, fine),
        ("insertion B; per end voxel", B, OnePerEndVoxel, Box, coarse),
        ("insertion B; per end voxel; unbounded", B, OnePerEndVoxel, Unbounded, coarse),
        ("insertion B; every point", B, EveryPoint, Box, coarse),
    ];
    let points = points.into_iter().flat_map(|(name, set, rays, space, sizes)| {
        sizes.iter().map(move |&size| {
            Stage::new(name, name_of(size), N_IMAGES, move |workload| {
                insert(workload, set, rays, space, size)
            })
        })
    });
    let frames = coarse.iter().map(|&size| {
        Stage::new("insertion of frames; D435i lens", name_of(size), N_IMAGES, move |w| {
            insert_frames(w, size)
        })
    });
    let snapshots = fine.iter().map(|&size| {
        Stage::new("snapshot", name_of(size), 1, move |workload| {
            let map = workload.map(A, size, N_IMAGES);
            std::boxed::Box::new(move || _ = black_box(map.snapshot(block(size))))
        })
    });
    points.chain(frames).chain(snapshots).collect()
}

fn insert(workload: &Workload, set: Set, rays: RayRule, space: Space, voxel_size: f64) -> TimedWork<'_> {
    let region = match space {
        Space::Box => Some(block(voxel_size)),
        Space::Unbounded => None,
    };
    let integration = Integration { rays, region, ..Default::default() };
    Box::new(move || {
        let mut map = empty_map(voxel_size);
        for (cloud, pose) in workload.clouds(set).iter().zip(&workload.poses) {
            let update = map.integrate_points(cloud, pose.translation(), &integration);
            update.expect("a cloud near the origin");
        }
        black_box(&map);
    })
}

/// A session's work on every image: object and walls, with the background carving.
fn insert_frames(workload: &Workload, voxel_size: f64) -> TimedWork<'_> {
    let room = Background::Room(Aabb::cube(glam::DVec3::ZERO, 0.6));
    let camera = SimulatedCamera::new(workload.meshes[0].clone(), Intrinsics::d435i(), room, 10.0)
        .expect("a sound camera");
    let frames: Vec<Frame> = workload.poses.iter().filter_map(|pose| camera.capture(pose).ok()).collect();
    let integration = Integration { region: Some(block(voxel_size)), ..Default::default() };
    Box::new(move || {
        let mut map = empty_map(voxel_size);
        frames.iter().for_each(|frame| _ = map.integrate(frame, &integration));
        black_box(&map);
    })
}
