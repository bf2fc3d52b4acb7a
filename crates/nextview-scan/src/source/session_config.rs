use crate::{Fault, ScanConfig};
use nextview::geometry::{Aabb, VoxelBlock};
use nextview::object::{ObjectBox, Table};
use nextview::registration::RegistrationConfig;
use nextview::sensor::{DepthRange, SurfaceNoise};
use nextview::session::SessionConfig;

/// Voxel size in metres if the box grows: the object's size is unknown when the voxels are chosen, and this
/// voxel size suits an object of 0.2 m.
pub(super) const VOXEL_SIZE: f64 = 0.005;

/// The session's part of a configuration, for this number of candidates and an object in this box on this
/// table, with a camera of unlimited depth range.
pub(super) fn session_config(
    config: &ScanConfig,
    n_candidates: usize,
    voxel_size: f64,
    object_box: ObjectBox,
    table: Table,
) -> SessionConfig {
    SessionConfig {
        voxel_size,
        multi_resolution: config.multi_resolution,
        object_box,
        max_gap: config.object_box.max_gap_m,
        table,
        first_view: config.first_view,
        depth_range: DepthRange::default(),
        surface_error: config.surface_error(),
        planned_error: SurfaceNoise::default(),
        goal: config.goal_mm.map(|goal| goal / 1e3),
        looks: config.looks,
        sensor_model: config.map.sensor_model,
        rays: config.map.rays,
        background: config.map.background,
        registration: registration(config),
        motion: config.motion,
        max_views: config.max_views(n_candidates),
        stop: config.stop,
        memory_limit_mb: config.memory_limit_mb,
    }
}

/// A simulated first pose that is right is known to be right.
fn registration(config: &ScanConfig) -> RegistrationConfig {
    let registration =
        RegistrationConfig { enabled: Some(config.registration_mode()), ..config.registration };
    #[cfg(feature = "simulated")]
    if config.noise.first_pose_is_right {
        use nextview::registration::GivenPoses::FirstIsRight;
        return RegistrationConfig { given_poses: FirstIsRight, ..registration };
    }
    registration
}

/// The voxels to plan in, if there are not too many.
pub(super) fn voxel_block(config: &SessionConfig, bounds: &Aabb) -> Result<VoxelBlock, Fault> {
    config.block(bounds).map_err(|error| match error {
        nextview::Error::TooLarge { .. } => Fault::from(error)
            .with_remedy("use a larger `voxel_size_m`, or allow more with `memory_limit_mb`"),
        error => error.into(),
    })
}

/// About a fortieth of an object's longest side in metres: 1, 2 or 5 times a power of ten, the nearest in
/// ratio.
pub(super) fn suitable_voxel_size(longest_side: f64) -> f64 {
    let wanted = longest_side / 40.0;
    let power = 10_f64.powf(wanted.log10().floor());
    let steps = [1.0, 2.0, 5.0, 10.0].map(|step| step * power);
    let ratio = |step: &f64| (step / wanted).ln().abs();
    let nearest = steps.into_iter().min_by(|a, b| ratio(a).total_cmp(&ratio(b)));
    // Through text, to make 0.005 the number a user would write.
    format!("{:.0e}", nearest.unwrap_or(wanted)).parse().unwrap_or(wanted)
}
