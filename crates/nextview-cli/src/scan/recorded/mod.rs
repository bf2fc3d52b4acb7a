//! `nextview scan --frames`: the recorded poses are the candidates, and the planner chooses among those not yet used.

mod config;
mod outcome;
mod truth;

pub(crate) use config::RecordingConfig;
pub(super) use outcome::{AccuracyMm, RecordedOutcome};

use super::finished::{Measured, collect};
use super::keeper::FrameKeeper;
use super::model::FinalModel;
use super::object::suitable_voxel_size;
use super::outcome::{Outcome, step_line};
use super::progress::Progress;
use super::quality::ModelQuality;
use super::results::Results;
use super::setting::{session_config, voxel_block};
use super::{Baselines, BoxRule, FinishedScan, Output, PlannerName, ScanConfig, TableRule, short_name};
use crate::Failure;
use crate::files::ResultFolder;
use nextview::sensor::{ColorImage, Frame};
use nextview::session::{NextView, ObjectBox, Session, SessionConfig, Table};
use nextview::view::ViewSpace;
use nextview_recording::{RecordedFrame, Recording, RecordingError};
use nextview_sim::run::{Step, run_with};
use std::path::Path;
use truth::TrueShape;

/// Where the box grows, nothing is known of the object's size when the voxels are chosen: they suit one of 0.2 m.
const VOXEL_SIZE: f64 = 0.005;

/// Scans the recorded frames and writes the results.
pub(super) fn scan(
    mut config: ScanConfig,
    recording_config: &RecordingConfig,
    keeper: Option<FrameKeeper>,
    output: &Output,
) -> Result<(), Failure> {
    let mut recording = Recording::open(Path::new(&config.object), &recording_config.read)?;
    let n_recorded = recording.frames.len();
    recording.frames =
        config.reach.filter(recording.frames, |frame| frame.world_from_camera.translation())?;
    let session_config = resolve(&mut config, recording_config, &recording)?;
    let truth = TrueShape::load(&config, recording_config, &session_config)?;
    check_planner(&config, truth.as_ref())?;
    let folder = ResultFolder::begin(&output.dir)?;
    let reach_note = config.reach.note(recording.frames.len(), n_recorded);
    let truth_note = truth.iter().flat_map(|truth| truth.note.clone());
    let notes = notes(&recording).chain(truth_note).chain(reach_note).collect::<Vec<_>>();
    output.begin(&config, &describe(&config, &recording), &notes, recording.frames.len())?;

    let needed = truth.as_ref().filter(|_| config.needs_truth());
    let shown = needed.map(|truth| truth.shown_by(&recording)).transpose()?;
    let baselines = shown.as_ref().map(|shown| Baselines::new(shown, &config));
    let visibility = shown.map(|shown| shown.visibility);
    let planner = config.build_planner(visibility)?;
    let session = Session::new(session_config, config.camera, views(&recording)?, planner)?;
    let mut keeper = keeper.map_or_else(|| FrameKeeper::begin(&config, &output.dir), Ok)?;
    let progress = Progress::new("scanning", config.views);
    let scan = run(session, &recording, &mut keeper, truth.as_ref(), config.stop.time_s, |step| {
        progress.step();
        let line = || step_line(step, step.measures.truth.as_ref(), baselines.as_ref());
        if output.json { Ok(()) } else { progress.print(&line()) }
    })?;
    drop(progress);
    let Some(scan) = scan else {
        keeper.finish();
        return Err(no_object());
    };
    let mut outcome = Outcome::new(&config, &scan, baselines);
    outcome.recorded = Some(RecordedOutcome::new(&recording, &scan));
    let model = FinalModel::new(&scan, |step| color(&recording, step))?;
    if let Some(truth) = &truth {
        outcome.model = ModelQuality::new(&model, &scan, &truth.surface);
    }
    Results { config: &config, scan: &scan, outcome: &outcome, model: &model }.write(folder)?;
    keeper.finish();
    output.end(&outcome)
}

/// Runs the session to its end over the recorded frames; none if they show no object.
fn run(
    mut session: Session,
    recording: &Recording,
    keeper: &mut FrameKeeper,
    truth: Option<&TrueShape>,
    time_limit_s: Option<f64>,
    tell: impl Fn(&Step<Measured>) -> Result<(), Failure>,
) -> Result<Option<FinishedScan<Measured>>, Failure> {
    let mut gauge = truth.map(TrueShape::gauge);
    let (steps, stop_reason) = collect(time_limit_s, tell, |on_step| {
        let load = |next: &NextView| Ok((keeper.keep(next, load(recording, next)?)?, ()));
        let measure = |session: &Session, frame: &Frame, ()| match &mut gauge {
            Some(gauge) => gauge.measure(session, frame),
            None => Measured::default(),
        };
        run_with(&mut session, load, measure, on_step)
    })?;
    Ok(session.bounds().map(|bounds| FinishedScan { session, bounds, steps, stop_reason }))
}

/// Writes into the configuration what the recording decides, and tells what follows for the session.
fn resolve(
    config: &mut ScanConfig,
    recording_config: &RecordingConfig,
    recording: &Recording,
) -> Result<SessionConfig, Failure> {
    config.check_views(recording.frames.len())?;
    config.camera = recording.intrinsics;
    let bounds = recording_config.bounds();
    let suitable = bounds.map_or(VOXEL_SIZE, |bounds| suitable_voxel_size(bounds.longest_side()));
    let voxel_size = *config.voxel_size_m.get_or_insert(suitable);
    config.object_box.rule = if bounds.is_some() { BoxRule::Known } else { BoxRule::Grows };
    let table = match (recording_config.table_z_m, config.object_box.table) {
        (Some(z), _) => Table::AtHeight(z),
        (None, TableRule::Fit) => Table::Fitted,
        _ => Table::None,
    };
    let object_box = bounds.map_or(ObjectBox::Growing, ObjectBox::Known);
    let session_config = session_config(config, voxel_size, object_box, table);
    bounds.map(|bounds| voxel_block(&session_config, &bounds)).transpose()?;
    Ok(session_config)
}

fn check_planner(config: &ScanConfig, truth: Option<&TrueShape>) -> Result<(), Failure> {
    if config.planner == PlannerName::Clairvoyant && truth.is_none() {
        let problem = "the clairvoyant planner needs the true object";
        return Err(Failure::usage(problem).with_hint("--truth names its mesh"));
    }
    Ok(())
}

/// Name, number of frames and size of the images.
fn describe(config: &ScanConfig, recording: &Recording) -> String {
    let (width, height) = (recording.intrinsics.width(), recording.intrinsics.height());
    let n = recording.frames.len();
    format!("{}: {n} recorded frames of {width} x {height} pixels", short_name(&config.object))
}

/// What the recording has to say, one line each.
fn notes(recording: &Recording) -> impl Iterator<Item = String> {
    let odd = recording.notes.iter().map(|note| format!("note: {note}"));
    odd.chain(recording.skipped.iter().map(|skipped| format!("skipped: {skipped}")))
}

fn views(recording: &Recording) -> Result<ViewSpace, Failure> {
    Ok(ViewSpace::new(recording.frames.iter().map(|frame| frame.world_from_camera).collect())?)
}

fn load(recording: &Recording, next: &NextView) -> Result<Frame, RecordingError> {
    let view = next.view.expect("all views are fixed candidates, the first one, too");
    recording.frames[view].load()
}

/// The colour image that belongs to a step's frame.
fn color<M>(recording: &Recording, step: &Step<M>) -> Result<Option<ColorImage>, Failure> {
    let view = step.report.view.map(|view| &recording.frames[view]);
    Ok(view.map_or(Ok(None), RecordedFrame::load_color)?)
}

fn no_object() -> Failure {
    Failure::data("the first frame shows no object, so that there is nothing to plan for")
        .with_hint("--first-view begins with another frame, --box-m states where the object is")
}
