use super::object::Object;
use crate::source::session_config::{session_config, voxel_block};
use crate::{BoxRule, Fault, Faults, ScanConfig, TableRule, files};
use nextview::geometry::{Lattice, Pose};
use nextview::object::{ObjectBox, Table};
use nextview::planner::ViewPlanner;
use nextview::session::{Session, SessionConfig, Views};
use nextview::view::ViewSpace;
use nextview_sim::quality::TrueSurface;
use nextview_sim::scene::Scene;
use nextview_sim::truth::ObjectVoxels;
use std::path::Path;
use std::sync::Arc;

/// An object in front of the camera, and the view candidates around it: shared by scans with different
/// planners.
pub struct SimulatedObject {
    object: Object,
    /// The object in its room, and the camera.
    pub scene: Scene,
    /// The view candidates.
    pub views: ViewSpace,
    /// The configured voxel size, or one that suits the object.
    pub voxel_size: f64,
    /// Voxels that contain some of the true surface.
    pub object_voxels: ObjectVoxels,
    /// The true surface, for evaluating final models.
    pub true_surface: TrueSurface,
    /// Note on the number of candidates within reach, if that is limited.
    reach_note: Option<String>,
}

impl SimulatedObject {
    /// Loads the object. Fails if it cannot be scanned as configured.
    pub fn new(config: &ScanConfig) -> Result<Self, Faults> {
        let object = Object::load(config)?;
        let voxel_size = object.voxel_size(config)?;
        let scene = object.scene(config)?.with_noise(config.noise.noise())?;
        let bounds = scene.planning_box(voxel_size);
        config.robot.as_ref().map_or(Ok(()), |robot| robot.check_beside(&bounds))?;
        let (views, reach_note) = config.within_reach(view_space(config, &scene)?)?;
        config.check_views(views.len())?;
        let session = simulated_session(config, views.len(), &scene, voxel_size);
        let block = voxel_block(&session, &bounds)?;
        let mesh = scene.camera().mesh();
        let object_voxels = ObjectVoxels::new(mesh, Lattice::new(voxel_size)?, block);
        let true_surface = TrueSurface::new(mesh);
        Ok(Self { object, scene, views, voxel_size, object_voxels, true_surface, reach_note })
    }

    /// Builds the session of a scan of the object by this planner.
    pub fn session(&self, config: &ScanConfig, planner: Box<dyn ViewPlanner>) -> Result<Session, Faults> {
        config.check_views(self.views.len())?;
        let session_config = simulated_session(config, self.views.len(), &self.scene, self.voxel_size);
        Ok(Session::new(session_config, config.camera, self.session_views(config)?, planner)?)
    }

    /// How it was turned since the previous scan; `None` if there is none.
    pub(super) fn now_from_before(&self) -> Option<Pose> {
        self.object.now_from_before
    }

    /// Name, size and number of triangles of the object.
    pub fn description(&self) -> String {
        self.object.to_string()
    }

    /// Notes for the user: a guessed unit, broken colours, candidates out of reach.
    pub fn notes(&self) -> Vec<String> {
        self.object.notes.iter().chain(&self.reach_note).cloned().collect()
    }

    /// The session's candidates. Those of a rule follow a growing box, which begins at the first view around
    /// the true object; those of a file are fixed.
    fn session_views(&self, config: &ScanConfig) -> Result<Views, Fault> {
        if config.object_box.rule == BoxRule::Known || config.view_space.rule().is_none() {
            return Ok(Views::Fixed(self.views.clone()));
        }
        let (center, size) = (self.scene.center(), self.scene.size());
        let unit = self.views.around(-center / size, 1.0 / size)?;
        // With wrong poses, the box may grow by phantom surface, and the candidates with it.
        let reach = Arc::new(config.held(|reach| reach.within(self.scene.room()))?);
        Ok(Views::Following { first: self.views.pose(config.first_view), unit, reach })
    }
}

fn simulated_session(
    config: &ScanConfig,
    n_candidates: usize,
    scene: &Scene,
    voxel_size: f64,
) -> SessionConfig {
    let object_box = match config.object_box.rule {
        BoxRule::Known => ObjectBox::Known(scene.planning_box(voxel_size)),
        BoxRule::Grows => ObjectBox::Growing,
    };
    let table = match config.object_box.table {
        TableRule::None => Table::None,
        TableRule::Known => Table::AtHeight(scene.room().min.z),
        TableRule::Fit => Table::Fitted,
    };
    let session = session_config(config, n_candidates, voxel_size, object_box, table);
    SessionConfig { depth_range: config.noise.depth_range(), ..session }
}

/// The candidates around the true object that are above its table, if it has one. Those of a rule lie within
/// the camera's depth range; those of a file are fixed.
fn view_space(config: &ScanConfig, scene: &Scene) -> Result<ViewSpace, Fault> {
    let (center, size) = (scene.center(), scene.size());
    let views = match config.view_space.rule() {
        Some(rule) => {
            let distance = config.view_distance(scene.bounds());
            let views = rule.views(center, size, distance, config.candidates, config.view_seed())?;
            views.within_range(center, size, config.noise.depth_range())
        }
        None => views_of_file(config, scene)?,
    };
    if config.object_box.table == TableRule::None {
        return Ok(views);
    }
    let lowest = scene.room().min.z + LOWEST_VIEW;
    let above = views.poses().iter().filter(|pose| pose.translation().z >= lowest);
    ViewSpace::new(above.copied().collect()).map_err(|_| {
        Fault::request("no view candidate is above the table")
            .with_remedy("`object_box.table` = none lets the object float")
    })
}

/// Minimum height of candidates above the table in metres. They must also be clear of the table that the
/// session finds, which is within a millimetre of the true one.
const LOWEST_VIEW: f64 = 0.03;

fn views_of_file(config: &ScanConfig, scene: &Scene) -> Result<ViewSpace, Fault> {
    let path = Path::new(&config.view_space.0);
    let hint = "`view_space` takes shell, sphere, hemisphere, tammes, rings, ring or a CSV file";
    let file = files::open(path).map_err(|fault| fault.with_remedy(hint))?;
    let views = ViewSpace::read_csv(file, scene.center()).map_err(|e| Fault::from(e).in_file(path))?;
    check_in_room(scene, &views).map_err(|fault| fault.in_file(path))?;
    Ok(views)
}

/// Fails if the simulated camera cannot stand at a view.
fn check_in_room(scene: &Scene, views: &ViewSpace) -> Result<(), Fault> {
    let room = scene.room();
    let outside = |view: &usize| !room.contains(views.pose(*view).translation());
    let Some(view) = (0..views.len()).find(outside) else { return Ok(()) };
    let fault = Fault::data(format!(
        "view {view} (counted from 0) is at {:.3} m, outside the room around the object, from {:.3} to {:.3} m",
        views.pose(view).translation(),
        room.min,
        room.max
    ));
    Err(fault.with_remedy("views must be in metres, and around the object"))
}
