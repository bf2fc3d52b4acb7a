//! `nextview scan`: one simulated scan from the configuration to the folder of results.

mod baselines;
mod config;
pub(crate) mod memory;
mod noise;
mod object;
mod outcome;
mod planner_name;
mod progress;
mod registration;
mod results;
mod setting;

pub(crate) use baselines::{Baselines, Truth};
pub(crate) use config::{BoxRule, Profile, ScanConfig, TableRule, UnitName, ViewSpaceName, merged};
pub(crate) use noise::NoiseModel;
pub(crate) use object::short_name;
pub(crate) use outcome::milliseconds;
pub(crate) use planner_name::{NbvNetConfig, PlannerConfigs, PlannerName};
pub(crate) use progress::Progress;
pub(crate) use setting::{FinishedScan, Setting};

use crate::files::ResultFolder;
use crate::{Failure, stdout};
use outcome::Outcome;
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
pub(crate) fn scan(mut config: ScanConfig, output: &Output) -> Result<(), Failure> {
    config.check_stop()?;
    let setting = Setting::new(&config)?;
    config.voxel_size_m = Some(setting.voxel_size);
    let folder = ResultFolder::begin(&output.dir)?;
    if output.json {
        setting.object.note.iter().for_each(|note| eprintln!("{note}"));
    } else {
        stdout::print(outcome::heading(&config, &setting))?;
    }
    let truth = config.needs_truth().then(|| truth(&setting)).transpose()?;
    let baselines = truth.as_ref().map(|truth| Baselines::new(truth, &config));
    let progress = Progress::new("scanning", config.views);
    let scan = setting.scan(&config, truth.as_ref(), |step| {
        progress.step();
        let line = || outcome::step_line(step, baselines.as_ref());
        if output.json { Ok(()) } else { progress.print(&line()) }
    })?;
    drop(progress);
    let outcome = Outcome::new(&config, &setting, &scan, baselines);
    Results { config: &config, scan: &scan, outcome: &outcome }.write(folder)?;
    stdout::print(if output.json { outcome.to_json()? } else { outcome.to_text(&output.dir) })
}

fn truth(setting: &Setting) -> Result<Truth, Failure> {
    let progress = Progress::new("baselines: looking from every view", setting.views.len());
    Truth::new(setting, || progress.step())
}
