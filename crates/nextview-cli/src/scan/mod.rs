//! `nextview scan`: one simulated scan from the configuration to the folder of results.

mod baselines;
mod config;
mod memory;
mod object;
mod outcome;
mod planner_name;
mod results;

pub(crate) use config::{Profile, ScanConfig, UnitName, ViewSpaceName};
pub(crate) use planner_name::PlannerName;

use crate::Failure;
use crate::files::{self, ResultFolder};
use baselines::Baselines;
use indicatif::{ProgressBar, ProgressStyle};
use nextview::geometry::Lattice;
use nextview::session::{Session, SessionConfig, StopConfig};
use nextview::view::ViewSpace;
use nextview_sim::run::{self, Step};
use nextview_sim::scene::Scene;
use nextview_sim::truth::ObjectVoxels;
use object::Object;
use outcome::Outcome;
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
    let voxel_size = *config.voxel_size_m.get_or_insert(object.suitable_voxel_size());
    let scene = Scene::new(object.mesh.clone(), config.camera)?;
    let views = view_space(&config, &scene)?;
    config.check_views(views.len())?;
    let session_config = session_config(&config, &scene, voxel_size);
    let block = session_config.block(&views)?;
    let folder = ResultFolder::begin(&output.dir)?;
    if !output.json {
        outcome::print_heading(&config, &object, &views);
    }
    let object_voxels = ObjectVoxels::new(scene.camera(), Lattice::new(voxel_size)?, block);
    let baselines = baselines(&config, &scene, &object_voxels, &views)?;
    let truth = baselines.as_ref().map(|baselines| baselines.truth.clone());
    let planner = config.planner.build(config.max_flow, config.seed, truth)?;
    let mut session = Session::new(session_config, config.camera, views, planner)?;
    let mut steps: Vec<Step> = Vec::new();
    let stop_reason = run::run(&mut session, &scene, &object_voxels, |step| {
        if !output.json {
            outcome::print_step(&step, baselines.as_ref());
        }
        steps.push(step);
    })?;
    let outcome = Outcome::new(&config, &object, &steps, stop_reason, session.views().len(), baselines);
    let bounds = session_config.bounds;
    Results { config: &config, bounds, session: &session, steps: &steps, outcome: &outcome }
        .write(&folder)?;
    folder.publish()?;
    outcome.print(output)
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
    let style = ProgressStyle::with_template("{msg} [{bar:30}] {pos}/{len}, {eta} left");
    let bar = ProgressBar::new(views.len() as u64)
        .with_style(style.expect("the template is well formed"))
        .with_message("baselines: looking from every view");
    let baselines = Baselines::new(scene, object, views, config, || bar.inc(1));
    bar.finish_and_clear();
    baselines.map(Some)
}

fn session_config(config: &ScanConfig, scene: &Scene, voxel_size: f64) -> SessionConfig {
    let stop = StopConfig { max_views: config.views, entropy_share: config.stop.entropy_share };
    SessionConfig {
        first_view: config.first_view,
        sensor_model: config.map.sensor_model,
        rays: config.map.rays,
        background: config.map.background,
        stop,
        memory_limit_mb: config.memory_limit_mb,
        ..SessionConfig::new(voxel_size, scene.planning_box(voxel_size))
    }
}

fn view_space(config: &ScanConfig, scene: &Scene) -> Result<ViewSpace, Failure> {
    match config.view_space.rule() {
        Some(rule) => Ok(rule.views(scene.center(), scene.size(), config.candidates, config.seed)?),
        None => {
            let path = Path::new(&config.view_space.0);
            let read = ViewSpace::read_csv(files::open(path)?, scene.center());
            read.map_err(|e| Failure::from(e).in_file(path))
        }
    }
}
