use super::config::SessionConfig;
use super::known_scene::KnownScene;
use crate::motion::Surroundings;
use crate::object::Place;
use crate::planner::Situation;

/// Adds to a situation what a session knows apart from map, candidates and camera: its frames, the visited
/// candidates, and the robot's travel time to each.
pub(super) fn known_situation<'a>(
    situation: Situation<'a>,
    config: &SessionConfig,
    scene: &'a KnownScene,
    visited: &'a [usize],
    approaches: Option<&'a [Option<f64>]>,
) -> Situation<'a> {
    let situation = situation
        .with_depth_range(config.depth_range)
        .with_surface_error(config.planned_error)
        .with_frames(&scene.frames.mapped)
        .with_max_views(config.max_views)
        .with_table(scene.map.place().table.map(|table| table.plane))
        .with_right_poses(scene.alignment.trusts_given_poses())
        .with_aligned_frames(scene.alignment.is_active())
        .with_visited(visited)
        .and_then(|situation| situation.with_finest_voxel_size(config.voxel_size))
        .and_then(|situation| situation.with_motion(config.motion, surroundings(scene)))
        .map(|situation| match &scene.quality {
            Some(quality) => quality.add_to(situation),
            None => situation,
        })
        .and_then(|situation| match approaches {
            Some(times) => situation.with_approaches(times),
            None => Ok(situation),
        });
    situation.expect("the session visits candidates in checked voxels")
}

/// Returns the obstacles that a moving camera must avoid.
pub(super) fn surroundings(scene: &KnownScene) -> Surroundings {
    let Place { bounds: object, table } = scene.map.place();
    Surroundings { object, floor: table.map(|table| table.floor()) }
}
