use super::finished::{FinishedScan, collect};
use super::object::Object;
use super::{BoxRule, ScanConfig, TableRule, Truth};
use crate::{Failure, files};
use nextview::geometry::{Aabb, Lattice, VoxelBlock};
use nextview::sensor::Frame;
use nextview::session::{NextView, ObjectBox, Session, SessionConfig, Table, Views};
use nextview::view::ViewSpace;
use nextview_sim::gauge::{Gauge, RunCamera};
use nextview_sim::quality::TrueSurface;
use nextview_sim::run::{Step, run_with};
use nextview_sim::scene::Scene;
use nextview_sim::truth::ObjectVoxels;
use std::path::Path;

/// An object before the camera, and the places from which it can be looked at: what scans of it by different planners
/// share.
pub(crate) struct Setting {
    pub object: Object,
    pub scene: Scene,
    pub views: ViewSpace,
    /// The configured voxel size, or else one that suits the object.
    pub voxel_size: f64,
    pub object_voxels: ObjectVoxels,
    /// What final models are measured against.
    pub true_surface: TrueSurface,
    /// How many candidates were left within reach, where that was asked for.
    pub reach_note: Option<String>,
}

impl Setting {
    /// Loads the object; fails if it cannot be scanned as configured.
    pub fn new(config: &ScanConfig) -> Result<Self, Failure> {
        let object = Object::load(config)?;
        let voxel_size = object.voxel_size(config)?;
        let scene = object.scene(config)?.with_noise(config.noise.noise())?;
        let (views, reach_note) = config.reach.views(view_space(config, &scene)?)?;
        config.check_views(views.len())?;
        let block =
            voxel_block(&simulated_session(config, &scene, voxel_size), &scene.planning_box(voxel_size))?;
        let mesh = scene.camera().mesh();
        let object_voxels = ObjectVoxels::new(mesh, Lattice::new(voxel_size)?, block);
        let true_surface = TrueSurface::new(mesh);
        Ok(Self { object, scene, views, voxel_size, object_voxels, true_surface, reach_note })
    }

    /// Scans the object from the first view to the last. The truth is for the clairvoyant planner only; every frame counts as
    /// `keep` gives it back.
    pub fn scan(
        &self,
        config: &ScanConfig,
        truth: Option<&Truth>,
        mut keep: impl FnMut(&NextView, Frame) -> Result<Frame, Failure>,
        tell: impl Fn(&Step) -> Result<(), Failure>,
    ) -> Result<FinishedScan, Failure> {
        config.check_views(self.views.len())?;
        let truth = truth.map(|truth| truth.visibility.clone());
        let planner = config.build_planner(truth)?;
        let session_config = simulated_session(config, &self.scene, self.voxel_size);
        let mut session = Session::new(session_config, config.camera, self.session_views(config), planner)?;
        let mut camera = RunCamera::new(&self.scene);
        let mut gauge = Gauge::new(&self.scene, &self.object_voxels);
        let capture = |next: &NextView| {
            let (frame, shown) = camera.capture(next)?;
            Ok((keep(next, frame)?, shown))
        };
        let measure = |session: &Session, frame: &Frame, shown| gauge.measure(session, frame, shown);
        let (steps, stop_reason) =
            collect(config.stop.time_s, tell, |on_step| run_with(&mut session, capture, measure, on_step))?;
        let bounds = session.bounds().unwrap_or_else(|| self.scene.planning_box(self.voxel_size));
        Ok(FinishedScan { session, bounds, steps, stop_reason })
    }

    /// The candidates as the session has them. Those of a rule move along with a box that grows, which begins where the
    /// first of the views around the true object is; those of a file stay where they are.
    fn session_views(&self, config: &ScanConfig) -> Views {
        if config.object_box.rule == BoxRule::Known || config.view_space.rule().is_none() {
            return Views::Fixed(self.views.clone());
        }
        let (center, size) = (self.scene.center(), self.scene.size());
        let unit = self.views.around(-center / size, 1.0 / size);
        // The box may grow by what is not there, when poses are wrong, and candidates with it.
        let reach = config.reach.rule().within(self.scene.room());
        Views::Following { first: self.views.pose(config.first_view), unit, reach }
    }
}

/// The voxels to plan in, if they are not too many.
pub(super) fn voxel_block(config: &SessionConfig, bounds: &Aabb) -> Result<VoxelBlock, Failure> {
    config.block(bounds).map_err(|error| match error {
        nextview::Error::TooLarge { .. } => Failure::from(error)
            .with_hint("use a larger --voxel-size-m, or allow more with memory_limit_mb in --config"),
        error => error.into(),
    })
}

fn simulated_session(config: &ScanConfig, scene: &Scene, voxel_size: f64) -> SessionConfig {
    let object_box = match config.object_box.rule {
        BoxRule::Known => ObjectBox::Known(scene.planning_box(voxel_size)),
        BoxRule::Grows => ObjectBox::Growing,
    };
    let table = match config.object_box.table {
        TableRule::None => Table::None,
        TableRule::Known => Table::AtHeight(scene.room().min.z),
        TableRule::Fit => Table::Fitted,
    };
    session_config(config, voxel_size, object_box, table)
}

/// What the session is told, of an object in this box on this table.
pub(super) fn session_config(
    config: &ScanConfig,
    voxel_size: f64,
    object_box: ObjectBox,
    table: Table,
) -> SessionConfig {
    SessionConfig {
        voxel_size,
        multi_resolution: config.multi_resolution.rule(),
        object_box,
        table,
        first_view: config.first_view,
        sensor_model: config.map.sensor_model,
        rays: config.map.rays,
        background: config.map.background,
        registration: config.registration.rule(),
        motion: config.motion.rule(),
        stop: config.stop.rules(config.views),
        memory_limit_mb: config.memory_limit_mb,
    }
}

/// The candidates around the true object that are above its table, if it has one.
fn view_space(config: &ScanConfig, scene: &Scene) -> Result<ViewSpace, Failure> {
    let views = match config.view_space.rule() {
        Some(rule) => rule.views(scene.center(), scene.size(), config.candidates, config.view_seed())?,
        None => views_of_file(config, scene)?,
    };
    if config.object_box.table == TableRule::None {
        return Ok(views);
    }
    let lowest = scene.room().min.z + LOWEST_VIEW;
    let above = views.poses().iter().filter(|pose| pose.translation().z >= lowest);
    ViewSpace::new(above.copied().collect()).map_err(|_| {
        Failure::usage("no view candidate is above the table").with_hint("--table none floats the object")
    })
}

/// How far above the table the lowest candidates are, metres: clear of it for the session, too, which fits it to a
/// millimetre.
const LOWEST_VIEW: f64 = 0.03;

fn views_of_file(config: &ScanConfig, scene: &Scene) -> Result<ViewSpace, Failure> {
    let path = Path::new(&config.view_space.0);
    let hint = "--view-space takes shell, sphere, hemisphere or a CSV file";
    let file = files::open(path).map_err(|failure| failure.with_hint(hint))?;
    let views = ViewSpace::read_csv(file, scene.center()).map_err(|e| Failure::from(e).in_file(path))?;
    check_in_room(scene, &views).map_err(|failure| failure.in_file(path))?;
    Ok(views)
}

/// Fails if a view is where the simulated camera cannot stand.
fn check_in_room(scene: &Scene, views: &ViewSpace) -> Result<(), Failure> {
    let room = scene.room();
    let outside = |view: &usize| !room.contains(views.pose(*view).translation());
    let Some(view) = (0..views.len()).find(outside) else { return Ok(()) };
    let failure = Failure::data(format!(
        "view {view} (counted from 0) is at {:.3} m, outside the room around the object, from {:.3} to {:.3} m",
        views.pose(view).translation(),
        room.min,
        room.max
    ));
    Err(failure.with_hint("views must be in metres, and around the place where the object is"))
}
