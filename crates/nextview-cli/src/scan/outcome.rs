use super::baselines::Baselines;
use super::memory;
use super::{BoxRule, FinishedScan, PlannerName, Profile, ScanConfig, Setting, TableRule};
use crate::Failure;
use nextview::session::StopReason;
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
    /// Object voxels that are occupied in the map, over object voxels, after each view.
    pub voxel_coverage: Vec<f64>,
    /// Occupied voxels that are no object voxels, after each view.
    pub false_voxels: Vec<usize>,
    /// Share of the true surface with a measured point within 1, 2, 5 mm, after each view.
    pub surface_coverage_1mm: Vec<f64>,
    pub surface_coverage_2mm: Vec<f64>,
    pub surface_coverage_5mm: Vec<f64>,
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
    pub plan_time_ms: Vec<f64>,
    pub map_time_ms: Vec<f64>,
    pub render_time_ms: Vec<f64>,
    pub baseline_time_ms: Option<f64>,
    pub peak_memory_mb: Option<f64>,
    /// Kept for the report, not printed.
    #[serde(skip)]
    pub baselines: Option<Baselines>,
    /// The box around the object and the plane of its table, in words; of what the scan was not told already.
    #[serde(skip)]
    found: Vec<(&'static str, String)>,
}

impl Outcome {
    pub fn new(
        config: &ScanConfig,
        setting: &Setting,
        scan: &FinishedScan,
        baselines: Option<Baselines>,
    ) -> Self {
        let steps = &scan.steps;
        let curve: Option<Vec<f64>> =
            baselines.as_ref().map(|b| steps.iter().map(|step| b.reachable_coverage(step)).collect());
        Self {
            object: setting.object.name.clone(),
            planner: config.planner,
            profile: config.profile,
            seed: config.seed,
            views: steps.len(),
            stop_reason: scan.stop_reason,
            voxel_size_m: config.voxel_size_m.unwrap_or_default(),
            n_candidates: setting.views.len(),
            view_ids: steps.iter().map(|s| s.report.view).collect(),
            voxel_coverage: steps.iter().map(|s| s.voxels.coverage()).collect(),
            false_voxels: steps.iter().map(|s| s.voxels.n_false).collect(),
            surface_coverage_1mm: steps.iter().map(|s| s.surface_coverage[0]).collect(),
            surface_coverage_2mm: steps.iter().map(|s| s.surface_coverage[1]).collect(),
            surface_coverage_5mm: steps.iter().map(|s| s.surface_coverage[2]).collect(),
            reachable_coverage: curve.as_ref().and_then(|curve| curve.last().copied()),
            reachable_coverage_curve: curve,
            random_curve: baselines.as_ref().map(|b| b.random.mean.clone()),
            clairvoyant_curve: baselines.as_ref().map(|b| b.clairvoyant.clone()),
            skill: baselines.as_ref().and_then(|b| b.skill(steps)),
            entropy_nats: steps.iter().map(|s| s.report.map.entropy).collect(),
            path_length_m: steps.last().map_or(0.0, |s| s.path_length),
            plan_time_ms: steps.iter().map(|s| milliseconds(s.plan_time)).collect(),
            map_time_ms: steps.iter().map(|s| milliseconds(s.map_time)).collect(),
            render_time_ms: steps.iter().map(|s| milliseconds(s.render_time)).collect(),
            baseline_time_ms: baselines.as_ref().map(|b| milliseconds(b.time)),
            peak_memory_mb: memory::peak_mb(),
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
        rows.push(("voxel coverage", last(&self.voxel_coverage)));
        rows.push(("false voxels", self.false_voxels.last().copied().unwrap_or_default().to_string()));
        rows.push(("surface within 2 mm", last(&self.surface_coverage_2mm)));
        rows.push(("surface within 5 mm", last(&self.surface_coverage_5mm)));
        rows.extend(self.found.iter().cloned());
        rows.push(("path length", format!("{:.2} m", self.path_length_m)));
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
fn found(config: &ScanConfig, last: Option<&Step>) -> Vec<(&'static str, String)> {
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
pub(super) fn heading(config: &ScanConfig, setting: &Setting) -> String {
    let Setting { object, views, .. } = setting;
    let size = object.mesh.bounds().size() * 1e3;
    // To a nanometre, so that 5 mm do not read 5.000000000000001.
    let voxel_mm = (config.voxel_size_m.unwrap_or_default() * 1e9).round() / 1e6;
    let note = object.note.as_ref().map(|note| format!("{note}\n")).unwrap_or_default();
    format!(
        "{}: {:.0} x {:.0} x {:.0} mm, {} triangles\n{note}\
         planner {}, profile {}, {} candidate views, voxels of {voxel_mm} mm\n\n\
         {:>4}  {:>6}  {:>9}  {:>9}  {:>10}  {:>10}  {:>7}\n",
        object.name,
        size.x,
        size.y,
        size.z,
        object.mesh.triangles().len(),
        config.planner,
        config.profile,
        views.len(),
        "step",
        "view",
        "seen",
        "surface",
        "new voxels",
        "planning",
        "path"
    )
}

/// The line of a step in the table.
pub(super) fn step_line(step: &Step, baselines: Option<&Baselines>) -> String {
    let seen = baselines.map_or("-".to_owned(), |b| format!("{:.1} %", 100.0 * b.reachable_coverage(step)));
    format!(
        "{:>4}  {:>6}  {:>9}  {:>7.1} %  {:>10}  {:>7.1} ms  {:>5.2} m\n",
        step.report.step,
        step.report.view.map_or("-".to_owned(), |view| view.to_string()),
        seen,
        100.0 * step.surface_coverage[1],
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
