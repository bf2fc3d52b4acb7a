use crate::flags::{quoted, word};
use crate::progress::Progress;
use crate::{Failure, interrupt, stdout};
use nextview::Cancel;
use nextview_report::{heading, page_of_scan, step_line, summary_text};
use nextview_scan::files::Overwrite;
use nextview_scan::{
    Fault, FrameSource, Interrupted, RecordedScan, Results, RunOptions, ScanConfig, ScanFolder, ScanJournal,
    ScanRecord, ScanRun, SimulatedObject, Simulation, SourceConfig, Truth, begin_results, write_results,
};
use std::io::Write;
use std::path::{Path, PathBuf};

/// Where results go and how to print them.
#[derive(Clone)]
pub(super) struct Output {
    /// The folder of the results.
    pub dir: PathBuf,
    /// Whether the user named it.
    pub is_named: bool,
    /// The files in it that may be replaced, except those that the scan reads.
    pub rule: Overwrite,
    /// The configuration file with which the scan was begun.
    pub config: Option<PathBuf>,
    /// Whether to print one JSON object instead of text.
    pub json: bool,
}

/// Scans the configured object and writes the results.
pub(super) fn begin(config: ScanConfig, output: Output) -> Result<(), Failure> {
    ScanJournal::check_free(&output.dir)?;
    stdout::print(scan(config, None, &output)?.0)
}

/// Scans the object, turns it as requested by the results, and continues the scan. If stdout is JSON, only
/// the results of both are printed.
pub(super) fn begin_and_turn(config: ScanConfig, output: Output) -> Result<(), Failure> {
    let first = Output { dir: config.first_placement(&output.dir)?, is_named: true, ..output.clone() };
    ScanJournal::check_free(&first.dir)?;
    ScanJournal::check_free(&output.dir)?;
    begin_results(&output.dir, output.rule(&config))?;
    let (text, record) = scan(config.clone(), None, &first)?;
    if record.next_placement.is_none() {
        let dir = first.dir.display();
        eprintln!("note: no other placement would show much more: the results in {dir} are complete");
        return stdout::print(text);
    }
    if !output.json {
        stdout::print(text + "\n")?;
    }
    begin(config.going_on_after(first.dir), output)
}

/// Resumes the scan in a folder, and writes the same results as without an interruption.
pub(super) fn resume(output: Output) -> Result<(), Failure> {
    let Interrupted { heading, journal, n_frames, damage } = ScanJournal::resume(&output.dir)?;
    let path = output.dir.join(ScanJournal::FILE);
    let config = ScanConfig::parse(&heading, Some(&path), None)?;
    if let Some(damage) = damage {
        eprintln!("note: {}: {damage}", path.display());
    }
    eprintln!("note: resuming after {n_frames} frame{}", if n_frames == 1 { "" } else { "s" });
    stdout::print(scan(config, Some(journal), &output)?.0)
}

/// Scans and writes the results; returns the closing text and the record.
fn scan(
    config: ScanConfig,
    journal: Option<ScanJournal>,
    output: &Output,
) -> Result<(String, ScanRecord), Failure> {
    match &config.source {
        SourceConfig::Simulated => simulated(config, journal, output),
        SourceConfig::Recording(_) => recorded(config, journal, output),
        SourceConfig::Live(_) => Err(own_camera().into()),
    }
}

/// The reason why this program cannot resume a scan with a user's camera.
fn own_camera() -> Fault {
    Fault::request("the frames of this scan come from a user's camera (`live`)")
        .with_remedy("resume it in the program that started it, in Python with `nextview.resume(dir)`")
}

fn simulated(
    mut config: ScanConfig,
    journal: Option<ScanJournal>,
    output: &Output,
) -> Result<(String, ScanRecord), Failure> {
    begin_results(&output.dir, output.rule(&config))?;
    let object = SimulatedObject::new(&config)?;
    config.voxel_size_m = Some(object.voxel_size);
    config.views = Some(config.max_views(object.views.len()));
    let notes = object.notes().into_iter().map(|note| word(&format!("note: {note}")));
    output.begin(&config, &object.description(), notes, object.views.len())?;
    let truth = config.needs_truth().then(|| {
        let progress = Progress::of_baselines(object.views.len());
        Truth::new(&object, &Cancel::default(), || progress.step())
    });
    let truth = truth.transpose()?;
    let folder = output.take(&config, journal)?;
    drive(&Simulation::new(&object, &config, truth.as_ref()), &config, folder, output.json)
}

fn recorded(
    mut config: ScanConfig,
    journal: Option<ScanJournal>,
    output: &Output,
) -> Result<(String, ScanRecord), Failure> {
    begin_results(&output.dir, output.rule(&config))?;
    let mut scan = RecordedScan::open(&mut config)?;
    let skipped = scan.skipped().into_iter().map(|skipped| format!("skipped: {skipped}"));
    let notes = scan.notes().iter().map(|note| word(&format!("note: {note}"))).chain(skipped);
    output.begin(&config, &scan.description(&config), notes, scan.n_views())?;
    scan.look(&config, &Cancel::default())?;
    let folder = output.take(&config, journal)?;
    drive(&scan, &config, folder, output.json)
}

/// Runs the scan to its end, and writes and prints the results.
fn drive(
    source: &dyn FrameSource,
    config: &ScanConfig,
    folder: ScanFolder,
    is_json: bool,
) -> Result<(String, ScanRecord), Failure> {
    let ScanFolder { dir, heading, journal, mut results } = folder;
    let mut run =
        ScanRun::begin(source, config, RunOptions { journal: Some(journal), ..RunOptions::default() })?;
    let progress = Progress::new("scanning", config.views.unwrap_or_default());
    let mut printed = Ok(());
    let stop_reason = run.drive(|step| {
        progress.step();
        if let Some(warning) = &step.warning {
            progress.warn(&word(&format!("warning: {warning}")));
        }
        if !is_json && printed.is_ok() {
            printed = progress.print(&step_line(step));
        }
        Ok(())
    })?;
    drop(progress);
    printed?;
    let mut scan = run.finish(Some(stop_reason));
    let Results { record, faults } = write_results(&mut results, config, &scan)?;
    let page = page_of_scan(&scan, &record, config, &command_again(&dir), &heading);
    results.add("report.html", |w| Ok(w.write_all(page.as_bytes())?))?;
    results.publish()?;
    if faults.is_some() && scan.bounds().is_none() {
        scan.forget_journal();
        eprintln!("note: {} holds the results so far; --force replaces them", dir.display());
    }
    faults.map_or(Ok(()), Err)?;
    scan.forget_journal();
    let printed = match is_json {
        true => serde_json::to_string(&record).map_err(Failure::data)? + "\n",
        false => {
            let dir = dir.display();
            format!("\n{}\nresults in {dir} (open report.html there)\n", word(&summary_text(&record, config)))
        }
    };
    Ok((printed, record))
}

/// The command that repeats the scan whose results are in this folder. Paths in a configuration are relative
/// to the working directory, and so is this folder's.
fn command_again(dir: &Path) -> String {
    let mut again = dir.as_os_str().to_owned();
    again.push("-again");
    let [config, again] = [dir.join("config.toml"), again.into()].map(|path| quoted(&path));
    format!("# in the folder where the scan was run\nnextview scan --config {config} --out {again}")
}

impl Output {
    fn take(&self, config: &ScanConfig, journal: Option<ScanJournal>) -> Result<ScanFolder, Failure> {
        let folder = ScanFolder::take(self.dir.clone(), !self.is_named, &self.rule(config), config, journal)?;
        interrupt::resumable("nextview scan --resume", &folder.dir, folder.dir.join(ScanJournal::FILE));
        Ok(folder)
    }

    /// The rule for replacing files, which protects all files that the scan reads.
    fn rule(&self, config: &ScanConfig) -> Overwrite {
        self.rule.clone().but(config.inputs().into_iter().chain(self.config.clone()).collect())
    }

    /// Prints the object and settings of the scan; notes go before the table, or to stderr if stdout is JSON.
    fn begin(
        &self,
        config: &ScanConfig,
        what: &str,
        notes: impl Iterator<Item = String>,
        n_views: usize,
    ) -> Result<(), Failure> {
        let notes: String = notes.map(|note| note + "\n").collect();
        if self.json {
            eprint!("{notes}");
            return Ok(());
        }
        stdout::print(heading(config, &format!("{what}\n{notes}"), n_views))
    }
}
