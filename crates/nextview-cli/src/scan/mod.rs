//! `nextview scan`: one scan, simulated or of recorded frames, from the configuration to the folder of results.

mod baselines;
mod config;
mod finished;
mod keeper;
pub(crate) mod memory;
mod model;
mod motion;
mod noise;
mod object;
mod outcome;
mod planner_name;
mod progress;
mod quality;
mod reach;
mod recorded;
mod registration;
mod results;
mod setting;

pub(crate) use baselines::{Baselines, Truth};
pub(crate) use config::{BoxRule, Profile, ScanConfig, TableRule, UnitName, ViewSpaceName, merged};
pub(crate) use finished::FinishedScan;
pub(crate) use motion::ways_so_far;
pub(crate) use noise::NoiseModel;
pub(crate) use object::short_name;
pub(crate) use outcome::milliseconds;
pub(crate) use planner_name::{NbvNetConfig, PlannerConfigs, PlannerName};
pub(crate) use progress::Progress;
pub(crate) use quality::QualityMm;
pub(crate) use recorded::RecordingConfig;
pub(crate) use setting::Setting;

use crate::files::ResultFolder;
use crate::{Failure, stdout};
use keeper::{FrameKeeper, Interrupted};
use model::FinalModel;
use nextview_sim::run::Step;
use outcome::Outcome;
use quality::ModelQuality;
use results::Results;
use std::path::PathBuf;

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
    PathBuf::from(format!("scan-{}-{}", short_name(&config.object), config.planner))
}

/// Scans the configured object and writes the results.
pub(crate) fn scan(config: ScanConfig, output: &Output) -> Result<(), Failure> {
    config.check_stop()?;
    FrameKeeper::check_free(&output.dir)?;
    run(config, None, output)
}

/// Goes on with a scan whose folder is named, and writes its results as if it had not been interrupted.
pub(crate) fn resume(output: &Output) -> Result<(), Failure> {
    let Interrupted { config, keeper, notes } = Interrupted::open(&output.dir)?;
    notes.iter().for_each(|note| eprintln!("{note}"));
    run(config, Some(keeper), output)
}

/// The keeper is that of an interrupted scan.
fn run(config: ScanConfig, keeper: Option<FrameKeeper>, output: &Output) -> Result<(), Failure> {
    match config.recording.clone() {
        Some(recording) => recorded::scan(config, &recording, keeper, output),
        None => simulated(config, keeper, output),
    }
}

fn simulated(mut config: ScanConfig, keeper: Option<FrameKeeper>, output: &Output) -> Result<(), Failure> {
    let setting = Setting::new(&config)?;
    config.voxel_size_m = Some(setting.voxel_size);
    let folder = ResultFolder::begin(&output.dir)?;
    let notes = setting.object.note.iter().chain(&setting.reach_note);
    output.begin(&config, &setting.object.to_string(), notes, setting.views.len())?;
    let truth = config.needs_truth().then(|| truth(&setting)).transpose()?;
    let baselines = truth.as_ref().map(|truth| Baselines::new(truth, &config));
    let mut keeper = keeper.map_or_else(|| FrameKeeper::begin(&config, &output.dir), Ok)?;
    let progress = Progress::new("scanning", config.views);
    let tell = |step: &Step| {
        progress.step();
        let line = || outcome::step_line(step, Some(&step.measures), baselines.as_ref());
        if output.json { Ok(()) } else { progress.print(&line()) }
    };
    let scan = setting.scan(&config, truth.as_ref(), |next, frame| keeper.keep(next, frame), tell)?;
    drop(progress);
    let scan = scan.told();
    let mut outcome = Outcome::new(&config, &scan, baselines);
    let model = FinalModel::new(&scan, |_| Ok(None))?;
    outcome.model = ModelQuality::new(&model, &scan, &setting.true_surface);
    Results { config: &config, scan: &scan, outcome: &outcome, model: &model }.write(folder)?;
    keeper.finish();
    output.end(&outcome)
}

impl Output {
    /// Tells what is scanned and how; notes go before the table, or to stderr where stdout is JSON.
    fn begin<'a>(
        &self,
        config: &ScanConfig,
        what: &str,
        notes: impl IntoIterator<Item = &'a String>,
        n_views: usize,
    ) -> Result<(), Failure> {
        let notes = notes.into_iter().map(|note| format!("{note}\n")).collect::<String>();
        if self.json {
            eprint!("{notes}");
            return Ok(());
        }
        stdout::print(outcome::heading(config, &format!("{what}\n{notes}"), n_views))
    }

    /// Tells what came of it.
    fn end(&self, outcome: &Outcome) -> Result<(), Failure> {
        stdout::print(if self.json { outcome.to_json()? } else { outcome.to_text(&self.dir) })
    }
}

fn truth(setting: &Setting) -> Result<Truth, Failure> {
    let progress = Progress::new("baselines: looking from every view", setting.views.len());
    Truth::new(setting, || progress.step())
}
