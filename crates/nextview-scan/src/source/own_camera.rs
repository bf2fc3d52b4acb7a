use super::session_config::{VOXEL_SIZE, session_config, suitable_voxel_size, voxel_block};
use crate::{
    BoxRule, Fault, Faults, LiveConfig, ScanConfig, TableRule, TurntableConfig, ViewRule, short_name,
};
use glam::DVec3;
use nextview::geometry::{Aabb, Pose};
use nextview::object::{ObjectBox, Table};
use nextview::sensor::{DepthImage, Frame, Intrinsics};
use nextview::session::{Session, SessionConfig, Views};
use nextview::view::ViewSpace;
use std::sync::Arc;

/// A user's camera in front of an unknown object: its frames are taken elsewhere and pushed into the run. See
/// [`LiveScan`](crate::LiveScan).
pub struct OwnCamera {
    intrinsics: Intrinsics,
    /// Depth up to which a pixel without return is free, in metres.
    range: f64,
    turntable: Option<TurntableConfig>,
    session_config: SessionConfig,
    views: Views,
    n_views: usize,
    reach_note: Option<String>,
}

/// Minimum height of a rule's candidates above the table in metres.
const LOWEST_VIEW: f64 = 0.03;

impl OwnCamera {
    /// Opens the configured camera and completes the configuration: number of views, voxel size, whether the
    /// box grows. Fails if the object cannot be scanned as configured.
    pub fn open(config: &mut ScanConfig) -> Result<Self, Faults> {
        let Some(live) = config.source.live().cloned() else {
            return Err(Fault::request("there is no `live` in the configuration").into());
        };
        config.check_with_files()?;
        let bounds = live.bounds();
        config.object_box.rule = if bounds.is_some() { BoxRule::Known } else { BoxRule::Grows };
        let suitable = bounds.map_or(VOXEL_SIZE, |bounds| suitable_voxel_size(bounds.longest_side()));
        let voxel_size = *config.voxel_size_m.get_or_insert(suitable);
        if let Some((robot, bounds)) = config.robot.as_ref().zip(bounds) {
            robot.check_beside(&bounds)?;
        }
        let Candidates { views, n_views, reach_note } = candidates(config, &live)?;
        config.check_views(n_views)?;
        config.views = Some(config.max_views(n_views));
        config.planner(None)?;
        let object_box = bounds.map_or(ObjectBox::Growing, ObjectBox::Known);
        let session_config = session_config(config, n_views, voxel_size, object_box, table(config, &live));
        let session_config = SessionConfig { depth_range: live.depth_range(), ..session_config };
        bounds.map(|bounds| voxel_block(&session_config, &bounds)).transpose()?;
        let (intrinsics, range) = (config.camera, live.max_depth_m);
        let turntable = config.turntable;
        Ok(Self { intrinsics, range, turntable, session_config, views, n_views, reach_note })
    }

    /// Builds the session of a configuration completed by [`open`](Self::open).
    pub fn session(&self, config: &ScanConfig) -> Result<Session, Faults> {
        let planner = config.planner(None)?;
        Ok(Session::new(self.session_config, self.intrinsics, self.views.clone(), planner)?)
    }

    /// Makes a frame from a depth image. Fails if it is not of the camera's size.
    pub fn frame(&self, image: DepthImage, world_from_camera: Pose) -> Result<Frame, Fault> {
        let (width, height) = (image.width(), image.height());
        let expected = (self.intrinsics.width(), self.intrinsics.height());
        if (width, height) != expected {
            let expected = format!("{} x {} pixels, as the camera has", expected.0, expected.1);
            return Err(Fault::of_value("depth", format!("{width} x {height}"), expected));
        }
        let image = match &self.turntable {
            Some(turntable) => turntable.turning_part(&image, &self.intrinsics)?,
            None => image,
        };
        Ok(Frame::new(image, self.intrinsics, world_from_camera, self.range)?)
    }

    /// Number of candidates.
    pub fn n_views(&self) -> usize {
        self.n_views
    }

    /// Name of the object and size of the images.
    pub fn description(&self, config: &ScanConfig) -> String {
        let (width, height) = (self.intrinsics.width(), self.intrinsics.height());
        format!("{}: a camera of {width} x {height} pixels", short_name(&config.object))
    }

    /// Notes for the user: candidates out of reach.
    pub fn notes(&self) -> Vec<String> {
        self.reach_note.iter().cloned().collect()
    }
}

fn table(config: &ScanConfig, live: &LiveConfig) -> Table {
    match (live.table_z_m, config.object_box.table) {
        (Some(z), _) => Table::AtHeight(z),
        (None, TableRule::Fit) => Table::Fitted,
        (None, _) if config.turntable.is_some() => Table::AtHeight(0.0),
        _ => Table::None,
    }
}

struct Candidates {
    views: Views,
    n_views: usize,
    /// Note on the number of candidates within reach, if that is limited.
    reach_note: Option<String>,
}

impl Candidates {
    /// The poses within reach.
    fn fixed(views: ViewSpace, config: &ScanConfig) -> Result<Self, Fault> {
        let (views, reach_note) = config.within_reach(views)?;
        Ok(Self { n_views: views.len(), views: Views::Fixed(views), reach_note })
    }
}

fn candidates(config: &ScanConfig, live: &LiveConfig) -> Result<Candidates, Fault> {
    if let Some(turntable) = &config.turntable {
        return Candidates::fixed(turntable.views(config.candidates)?, config);
    }
    if !live.poses.is_empty() {
        return Candidates::fixed(ViewSpace::new(live.poses.clone())?, config);
    }
    let Some(rule) = config.view_space.rule() else {
        let fault = Fault::of_value(
            "view_space",
            &config.view_space.0,
            "shell, sphere, hemisphere, tammes, rings or ring",
        );
        return Err(fault.with_remedy("`live.poses` takes candidates of your own"));
    };
    match live.bounds() {
        Some(bounds) => Candidates::fixed(around(rule, bounds, config, live)?, config),
        None => following(rule, config, live),
    }
}

/// The candidates of a rule around a known box: within the camera's depth range and above its table.
fn around(rule: ViewRule, bounds: Aabb, config: &ScanConfig, live: &LiveConfig) -> Result<ViewSpace, Fault> {
    let (center, size) = (bounds.center(), 0.5 * bounds.longest_side());
    let views =
        rule.views(center, size, config.view_distance(&bounds), config.candidates, config.view_seed())?;
    let views = views.within_range(center, size, live.depth_range());
    // A table that must still be found is not below the object.
    let fitted = (config.object_box.table == TableRule::Fit).then_some(bounds.min.z);
    let Some(table) = live.table_z_m.or(fitted) else { return Ok(views) };
    let above = views.poses().iter().filter(|pose| pose.translation().z >= table + LOWEST_VIEW);
    ViewSpace::new(above.copied().collect())
        .map_err(|_| Fault::request("no view candidate is above the table").with_remedy("check `live.box_m`"))
}

/// The candidates of a rule that follow the box.
fn following(rule: ViewRule, config: &ScanConfig, live: &LiveConfig) -> Result<Candidates, Fault> {
    let Some(first) = live.first_pose else {
        let message = "nothing is known of the object, so the pose of a view that shows part of it is needed";
        let fault =
            Fault::request(message).with_remedy("state `live.first_pose`, `live.box_m` or `live.poses`");
        return Err(Fault { key: Some("live.first_pose".to_owned()), ..fault });
    };
    let unit = rule.views(DVec3::ZERO, 1.0, None, config.candidates, config.view_seed())?;
    let n_views = unit.len();
    let views = Views::Following { first, unit, reach: Arc::new(config.held(|reach| reach)?) };
    Ok(Candidates { views, n_views, reach_note: None })
}
