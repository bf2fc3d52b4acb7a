//! `nextview scan`: one simulated scan from the configuration to the folder of results.

mod baselines;
mod config;
mod memory;
mod object;
mod outcome;
mod planner_name;
mod progress;
mod results;

pub(crate) use config::{BoxRule, Profile, ScanConfig, TableRule, UnitName, ViewSpaceName};
pub(crate) use planner_name::PlannerName;

use crate::files::{self, ResultFolder};
use crate::{Failure, stdout};
use baselines::Baselines;
use nextview::geometry::{Aabb, Lattice, VoxelBlock};
use nextview::session::{ObjectBox, Session, SessionConfig, StopConfig, StopReason, Table, Views};
use nextview::view::ViewSpace;
use nextview_sim::run::{self, Step};
use nextview_sim::scene::Scene;
use nextview_sim::truth::ObjectVoxels;
use object::Object;
use outcome::Outcome;
use progress::Progress;
use results::Results;
use std::path::{Path, PathBuf};

/// Where the results go and how they are told.
#[derive(Debug)]
pub(crate) struct Output {
    /// The folder.
    pub dir: PathBuf,
    /// Whether to print one JSON object instead of text.
    pub json: bool,
}

/// The folder for the results where none is named.
pub(crate) fn default_dir(config: &ScanConfig) -> PathBuf {
    PathBuf::from(format!("scan-{}-{}", object::short_name(&config.object), config.planner))
}

/// Scans the configured object and writes the results.
pub(crate) fn scan(mut config: ScanConfig, output: &Output) -> Result<(), Failure> {
    let object = Object::load(&config)?;
    let voxel_size = object.voxel_size(&config)?;
    config.voxel_size_m = Some(voxel_size);
    let scene = object.scene(&config)?;
    let views = view_space(&config, &scene)?;
    config.check_views(views.len())?;
    let session_config = session_config(&config, &scene, voxel_size);
    let block = voxel_block(&session_config, &scene.planning_box(voxel_size))?;
    let folder = ResultFolder::begin(&output.dir)?;
    if output.json {
        object.note.iter().for_each(|note| eprintln!("{note}"));
    } else {
        stdout::print(outcome::heading(&config, &object, &views))?;
    }
    let object_voxels = ObjectVoxels::new(scene.camera(), Lattice::new(voxel_size)?, block);
    let baselines = baselines(&config, &scene, &object_voxels, &views)?;
    let truth = baselines.as_ref().map(|baselines| baselines.truth.clone());
    let planner = config.planner.build(config.max_flow, config.greedy, config.seed, truth)?;
    let mut session =
        Session::new(session_config, config.camera, session_views(&config, &scene, &views), planner)?;
    let progress = Progress::new("scanning", config.views);
    let (steps, stop_reason) = run_session(&mut session, &scene, &object_voxels, |step| {
        progress.step();
        let line = || outcome::step_line(step, baselines.as_ref());
        if output.json { Ok(()) } else { progress.print(&line()) }
    })?;
    drop(progress);
    let outcome = Outcome::new(&config, &object, &steps, stop_reason, session.views().len(), baselines);
    let bounds = session.bounds().unwrap_or_else(|| scene.planning_box(voxel_size));
    Results { config: &config, bounds, session: &session, steps: &steps, outcome: &outcome }.write(folder)?;
    stdout::print(if output.json { outcome.to_json()? } else { outcome.to_text(&output.dir) })
}

/// Runs the session to its end and collects its steps.
fn run_session(
    session: &mut Session,
    scene: &Scene,
    object: &ObjectVoxels,
    tell: impl Fn(&Step) -> Result<(), Failure>,
) -> Result<(Vec<Step>, StopReason), Failure> {
    let mut steps: Vec<Step> = Vec::new();
    let mut told = Ok(());
    let stop_reason = run::run(session, scene, object, |step| {
        if told.is_ok() {
            told = tell(&step);
        }
        steps.push(step);
    })?;
    told.map(|()| (steps, stop_reason))
}

/// The two bounds of every planner, if they are asked for or the planner is one of them.
fn baselines(
    config: &ScanConfig,
    scene: &Scene,
    object: &ObjectVoxels,
    views: &ViewSpace,
) -> Result<Option<Baselines>, Failure> {
    if !config.baselines && config.planner != PlannerName::Clairvoyant {
        return Ok(None);
    }
    let progress = Progress::new("baselines: looking from every view", views.len());
    Baselines::new(scene, object, views, config, || progress.step()).map(Some)
}

/// The voxels to plan in, if they are not too many.
fn voxel_block(config: &SessionConfig, bounds: &Aabb) -> Result<VoxelBlock, Failure> {
    config.block(bounds).map_err(|error| match error {
        nextview::Error::TooLarge { .. } => Failure::from(error)
            .with_hint("use a larger --voxel-size-m, or allow more with memory_limit_mb in --config"),
        error => error.into(),
    })
}

fn session_config(config: &ScanConfig, scene: &Scene, voxel_size: f64) -> SessionConfig {
    let stop = StopConfig { max_views: config.views, entropy_share: config.stop.entropy_share };
    let known = scene.planning_box(voxel_size);
    SessionConfig {
        multi_resolution: config.multi_resolution.rule(),
        object_box: match config.object_box.rule {
            BoxRule::Known => ObjectBox::Known(known),
            BoxRule::Grows => ObjectBox::Growing,
        },
        table: match config.object_box.table {
            TableRule::None => Table::None,
            TableRule::Known => Table::AtHeight(scene.room().min.z),
            TableRule::Fit => Table::Fitted,
        },
        first_view: config.first_view,
        sensor_model: config.map.sensor_model,
        rays: config.map.rays,
        background: config.map.background,
        stop,
        memory_limit_mb: config.memory_limit_mb,
        ..SessionConfig::new(voxel_size, known)
    }
}

/// The candidates around the true object that are above its table, if it has one.
fn view_space(config: &ScanConfig, scene: &Scene) -> Result<ViewSpace, Failure> {
    let views = match config.view_space.rule() {
        Some(rule) => rule.views(scene.center(), scene.size(), config.candidates, config.seed)?,
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

/// The candidates as the session has them. Those of a rule move along with a box that grows, which begins where the
/// first of the views around the true object is; those of a file stay where they are.
fn session_views(config: &ScanConfig, scene: &Scene, views: &ViewSpace) -> Views {
    if config.object_box.rule == BoxRule::Known || config.view_space.rule().is_none() {
        return Views::Fixed(views.clone());
    }
    let unit = views.around(-scene.center() / scene.size(), 1.0 / scene.size());
    Views::Following { first: views.pose(config.first_view), unit }
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
