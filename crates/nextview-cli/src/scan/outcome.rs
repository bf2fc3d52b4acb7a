use super::baselines::Baselines;
use super::finished::Measured;
use super::memory;
use super::quality::{ModelQuality, QualityMm};
use super::recorded::RecordedOutcome;
use super::ways_so_far;
use super::{BoxRule, FinishedScan, PlannerName, Profile, ScanConfig, TableRule, short_name};
use crate::Failure;
use nextview::session::StopReason;
use nextview_sim::gauge::Measures;
use nextview_sim::run::Step;
use serde::Serialize;
use std::path::Path;
use std::time::Duration;

/// The measures of a scan: what `--json` prints. Entries that differ between equal runs are times and memory only.
#[derive(Debug, Serialize)]
pub(super) struct Outcome {
    pub object: String,
    pub planner: PlannerName,
    pub profile: Profile,
    pub seed: u64,
    /// Number of views taken.
    pub views: usize,
    pub stop_reason: StopReason,
    pub voxel_size_m: f64,
    pub n_candidates: usize,
    /// Numbers of the views, in order; none for a first view that is no candidate.
    pub view_ids: Vec<Option<usize>>,
    /// Object voxels that are occupied in the map, over object voxels, after each view; this and the next four none where
    /// the truth is not known.
    pub voxel_coverage: Option<Vec<f64>>,
    /// Occupied voxels that are no object voxels, after each view.
    pub false_voxels: Option<Vec<usize>>,
    /// Share of the true surface with a measured point within 1, 2, 5 mm, after each view.
    pub surface_coverage_1mm: Option<Vec<f64>>,
    pub surface_coverage_2mm: Option<Vec<f64>>,
    pub surface_coverage_5mm: Option<Vec<f64>>,
    /// Object voxels seen, over those that any candidate sees, at the end and after each view; none without baselines.
    pub reachable_coverage: Option<f64>,
    pub reachable_coverage_curve: Option<Vec<f64>>,
    /// The same for random views (mean) and for the clairvoyant planner.
    pub random_curve: Option<Vec<f64>>,
    pub clairvoyant_curve: Option<Vec<f64>>,
    /// Area under the curve from random (0) to clairvoyant (1).
    pub skill: Option<f64>,
    /// Map entropy in the box, nats, after each view.
    pub entropy_nats: Vec<f64>,
    pub path_length_m: f64,
    /// Length of all ways around the object, and the time that they take.
    pub way_m: f64,
    pub move_time_s: f64,
    pub plan_time_ms: Vec<f64>,
    pub map_time_ms: Vec<f64>,
    /// Time to render or to load the frames.
    pub render_time_ms: Vec<f64>,
    pub baseline_time_ms: Option<f64>,
    pub peak_memory_mb: Option<f64>,
    /// Of the final cloud and mesh; none where the truth is not known.
    #[serde(flatten)]
    pub model: ModelQuality,
    /// Of recordings only.
    #[serde(flatten)]
    pub recorded: Option<RecordedOutcome>,
    /// Kept for the report, not printed.
    #[serde(skip)]
    pub baselines: Option<Baselines>,
    /// The box around the object and the plane of its table, in words; of what the scan was not told already.
    #[serde(skip)]
    found: Vec<(&'static str, String)>,
}

impl Outcome {
    pub fn new(config: &ScanConfig, scan: &FinishedScan<Measured>, baselines: Option<Baselines>) -> Self {
        let steps = &scan.steps;
        let truths: Option<Vec<&Measures>> = steps.iter().map(|step| step.measures.truth.as_ref()).collect();
        let known = baselines.as_ref().zip(truths.as_ref());
        let curve: Option<Vec<f64>> =
            known.map(|(b, truths)| truths.iter().map(|truth| b.reachable_coverage(truth)).collect());
        let [way_m, move_time_s] = ways_so_far(steps).last().unwrap_or_default();
        let surface_coverage =
            |i: usize| truths.as_ref().map(|truths| truths.iter().map(|t| t.surface_coverage[i]).collect());
        Self {
            object: short_name(&config.object),
            planner: config.planner,
            profile: config.profile,
            seed: config.seed,
            views: steps.len(),
            stop_reason: scan.stop_reason,
            voxel_size_m: config.voxel_size_m.unwrap_or_default(),
            n_candidates: scan.session.views().len(),
            view_ids: steps.iter().map(|s| s.report.view).collect(),
            voxel_coverage: truths
                .as_ref()
                .map(|truths| truths.iter().map(|t| t.voxels.coverage()).collect()),
            false_voxels: truths.as_ref().map(|truths| truths.iter().map(|t| t.voxels.n_false).collect()),
            surface_coverage_1mm: surface_coverage(0),
            surface_coverage_2mm: surface_coverage(1),
            surface_coverage_5mm: surface_coverage(2),
            reachable_coverage: curve.as_ref().and_then(|curve| curve.last().copied()),
            reachable_coverage_curve: curve,
            random_curve: baselines.as_ref().map(|b| b.random.mean.clone()),
            clairvoyant_curve: baselines.as_ref().map(|b| b.clairvoyant.clone()),
            skill: known.and_then(|(b, truths)| b.skill(truths.iter().copied())),
            entropy_nats: steps.iter().map(|s| s.report.map.entropy).collect(),
            path_length_m: steps.last().map_or(0.0, |s| s.path_length),
            way_m,
            move_time_s,
            plan_time_ms: steps.iter().map(|s| milliseconds(s.plan_time)).collect(),
            map_time_ms: steps.iter().map(|s| milliseconds(s.map_time)).collect(),
            render_time_ms: steps.iter().map(|s| milliseconds(s.capture_time)).collect(),
            baseline_time_ms: baselines.as_ref().map(|b| milliseconds(b.time)),
            peak_memory_mb: memory::peak_mb(),
            model: ModelQuality::default(),
            recorded: None,
            baselines,
            found: found(config, steps.last()),
        }
    }

    /// Label and value of the measures, for people.
    pub fn summary(&self) -> Vec<(String, String)> {
        let percent = |share: f64| format!("{:.1} %", 100.0 * share);
        let last = |values: &[f64]| percent(values.last().copied().unwrap_or_default());
        let mut rows = vec![
            ("views taken", format!("{} of {} candidates", self.views, self.n_candidates)),
            ("stopped because", stop_phrase(self.stop_reason).to_owned()),
        ];
        if let (Some(reached), Some(random), Some(clairvoyant)) =
            (self.reachable_coverage, &self.random_curve, &self.clairvoyant_curve)
        {
            rows.push(("seen of the reachable", percent(reached)));
            rows.push(("  random views", last(random)));
            rows.push(("  clairvoyant", last(clairvoyant)));
        }
        if let Some(skill) = self.skill {
            rows.push(("skill", format!("{skill:.2}  (0 = random views, 1 = knows the object)")));
        }
        let share = |label, curve: &Option<Vec<f64>>| curve.as_ref().map(|curve| (label, last(curve)));
        rows.extend(share("voxel coverage", &self.voxel_coverage));
        let false_voxels = self.false_voxels.iter().map(|n| n.last().copied().unwrap_or_default());
        rows.extend(false_voxels.map(|n| ("false voxels", n.to_string())));
        rows.extend(share("surface within 2 mm", &self.surface_coverage_2mm));
        rows.extend(share("surface within 5 mm", &self.surface_coverage_5mm));
        let phrase = |label, quality: Option<QualityMm>| quality.map(|quality| (label, quality.phrase()));
        rows.extend(phrase("cloud", self.model.cloud));
        rows.extend(phrase("mesh", self.model.mesh));
        rows.extend(self.recorded.iter().flat_map(RecordedOutcome::rows));
        rows.extend(self.found.iter().cloned());
        rows.push(("path length", format!("{:.2} m", self.path_length_m)));
        rows.push(("way around the object", format!("{:.2} m in {:.1} s", self.way_m, self.move_time_s)));
        rows.push((
            "planning time",
            format!("{:.1} ms a view (median)", median(&self.plan_time_ms[1.min(self.views)..])),
        ));
        rows.push(("map update", format!("{:.1} ms a view (median)", median(&self.map_time_ms))));
        if let Some(time) = self.baseline_time_ms {
            rows.push(("baselines took", format!("{:.1} s, apart from the scan", time / 1000.0)));
        }
        if let Some(peak) = self.peak_memory_mb {
            rows.push(("peak memory", format!("{peak:.0} MB")));
        }
        rows.into_iter().map(|(label, value)| (label.to_owned(), value)).collect()
    }

    /// One JSON object on a line.
    pub fn to_json(&self) -> Result<String, Failure> {
        Ok(serde_json::to_string(self).map_err(Failure::data)? + "\n")
    }

    /// The measures as a table, and where the results are.
    pub fn to_text(&self, dir: &Path) -> String {
        let rows: String =
            self.summary().iter().map(|(label, value)| format!("{label:<22} {value}\n")).collect();
        format!("\n{rows}\nresults in {} (open report.html there)\n", dir.display())
    }
}

/// Where the object and its table are, if the scan had to find out.
fn found<M>(config: &ScanConfig, last: Option<&Step<M>>) -> Vec<(&'static str, String)> {
    let (bounds, table) = last.map_or((None, None), |step| (step.report.bounds, step.report.table));
    let mut rows = Vec::new();
    if config.object_box.rule == BoxRule::Grows {
        let size = bounds.map(|bounds| bounds.size() * 1e3);
        let size = size.map(|mm| format!("{:.0} x {:.0} x {:.0} mm", mm.x, mm.y, mm.z));
        rows.push(("box found", size.unwrap_or("none".to_owned())));
    }
    if config.object_box.table == TableRule::Fit {
        let height =
            table.zip(bounds).map(|(table, bounds)| -table.height(bounds.center().with_z(0.0)) * 1e3);
        let height = height.map_or("none".to_owned(), |mm| {
            // Added to 0, so that it does not read -0.0.
            format!("at z = {:.1} mm", (mm * 10.0).round() / 10.0 + 0.0)
        });
        rows.push(("table found", height));
    }
    rows
}

/// What is scanned and how, and the head of the table of steps.
pub(super) fn heading(config: &ScanConfig, what: &str, n_views: usize) -> String {
    // To a nanometre, so that 5 mm do not read 5.000000000000001.
    let voxel_mm = (config.voxel_size_m.unwrap_or_default() * 1e9).round() / 1e6;
    format!(
        "{what}planner {}, profile {}, {n_views} candidate views, voxels of {voxel_mm} mm\n\n\
         {:>4}  {:>6}  {:>9}  {:>9}  {:>10}  {:>10}  {:>7}\n",
        config.planner, config.profile, "step", "view", "seen", "surface", "new voxels", "planning", "path"
    )
}

/// The line of a step in the table, as far as the truth is known.
pub(super) fn step_line<M>(
    step: &Step<M>,
    truth: Option<&Measures>,
    baselines: Option<&Baselines>,
) -> String {
    let percent =
        |share: Option<f64>| share.map_or("-".to_owned(), |share| format!("{:.1} %", 100.0 * share));
    format!(
        "{:>4}  {:>6}  {:>9}  {:>9}  {:>10}  {:>7.1} ms  {:>5.2} m\n",
        step.report.step,
        step.report.view.map_or("-".to_owned(), |view| view.to_string()),
        percent(baselines.zip(truth).map(|(baselines, truth)| baselines.reachable_coverage(truth))),
        percent(truth.map(|truth| truth.surface_coverage[1])),
        step.report.update.n_newly_occupied,
        milliseconds(step.plan_time),
        step.path_length,
    )
}

/// Why a scan stopped, as a phrase.
pub(super) fn stop_phrase(reason: StopReason) -> &'static str {
    match reason {
        StopReason::ViewLimit => "the view limit was reached",
        StopReason::Converged => "the map's entropy fell below its threshold (converged)",
        StopReason::Complete => "the surface is estimated to be as complete as asked for",
        StopReason::LittleToGain => "the next view is expected to add less than asked for",
        StopReason::TimeLimit => "the time allowed was over",
        StopReason::PathLimit => "the path would become longer than allowed",
        StopReason::NothingToGain => "no candidate gains anything",
        StopReason::NoObject => "the camera saw no object",
        StopReason::BoxTooLarge => "the object's box would need more memory than allowed",
    }
}

pub(crate) fn milliseconds(time: Duration) -> f64 {
    time.as_secs_f64() * 1e3
}

/// The middle value; zero of none.
fn median(values: &[f64]) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted.get(sorted.len() / 2).copied().unwrap_or_default()
}
