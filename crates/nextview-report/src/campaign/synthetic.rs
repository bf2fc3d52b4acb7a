//! Synthetic campaigns for tests.

use nextview::session::StopReason;
use nextview_campaign::store::{StoredRuns, read};
use nextview_campaign::{DoneRun, Host, RunRecord, RunResult};
use nextview_scan::{BuildIdentity, PlannerName, Profile, QualityMm, ScanConfig, ScanRecord, StepRecord};
use std::sync::atomic::{AtomicUsize, Ordering};

const OBJECTS: [(&str, &str); 6] = [
    ("builtin", "mug"),
    ("lm", "lm_obj_000004_camera"),
    ("lm", "lm_obj_000006_cat"),
    ("lm", "lm_obj_000013_iron"),
    ("stanford", "bunny"),
    ("stanford", "happy_buddha"),
];

/// The planner of each variant by its name: APORA, RSE or random, and max-flow for any other.
fn planner(variant: &str) -> PlannerName {
    match variant {
        "apora" => PlannerName::Apora,
        "rse" => PlannerName::Rse,
        "random" => PlannerName::Random,
        _ => PlannerName::MaxFlow,
    }
}

/// A mutable campaign in memory.
#[derive(Clone)]
pub(crate) struct Campaign {
    pub name: String,
    pub runs: Vec<RunRecord>,
    pub torn: bool,
}

impl Campaign {
    /// Passes the campaign, as stored in a folder, to `make`.
    pub fn stored<T>(&self, make: impl FnOnce(&StoredRuns) -> T) -> T {
        static NUMBER: AtomicUsize = AtomicUsize::new(0);
        let number = NUMBER.fetch_add(1, Ordering::Relaxed);
        let folder = std::env::temp_dir().join(format!("nextview-report-{number}-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let lines = self.runs.iter().map(|run| serde_json::to_string(run).unwrap() + "\n");
        std::fs::write(folder.join("runs.jsonl"), lines.collect::<String>()).unwrap();
        let stored = StoredRuns { name: self.name.clone(), torn: self.torn, ..read(&folder).unwrap() };
        let made = make(&stored);
        std::fs::remove_dir_all(&folder).unwrap();
        made
    }
}

/// A campaign of these variants, each better than the one before, on the first `n_objects` of six objects.
pub(crate) fn campaign(variants: &[&str], n_objects: usize) -> Campaign {
    let runs = variants.iter().enumerate().flat_map(|(i, variant)| {
        OBJECTS[..n_objects].iter().enumerate().map(move |(j, object)| run(variant, *object, i, j))
    });
    let mut runs: Vec<RunRecord> = runs.collect();
    runs.sort_by_key(RunRecord::id);
    Campaign { name: "made-up".to_owned(), runs, torn: false }
}

/// The record of a run, mutable.
pub(crate) fn record_mut(run: &mut RunRecord) -> &mut ScanRecord {
    match &mut run.result {
        RunResult::Done(done) => &mut done.record,
        RunResult::Failed(reason) => panic!("{reason}"),
    }
}

const N_VIEWS: usize = 10;

fn run(variant: &str, (data_set, object): (&str, &str), rank: usize, object_idx: usize) -> RunRecord {
    let config = ScanConfig {
        object: format!("meshes/{object}.ply"),
        planner: planner(variant).into(),
        views: Some(N_VIEWS),
        voxel_size_m: Some(0.005),
        ..ScanConfig::of_profile(Profile::Default)
    };
    let rate = 0.3 + 0.08 * rank as f64 + 0.02 * (object_idx * (rank + 2) % 5) as f64;
    let mut record = ScanRecord {
        object: object.to_owned(),
        planner: config.planner.clone(),
        profile: config.profile,
        object_voxels: Some(1000),
        reachable_voxels: Some(960),
        stop_reason: Some(StopReason::ViewLimit),
        views: N_VIEWS,
        steps: (1..=N_VIEWS).map(|view| step(view, rate)).collect(),
        random_curve: Some((1..=N_VIEWS).map(|view| saturating(0.32, view)).collect()),
        clairvoyant_curve: Some((1..=N_VIEWS).map(|view| saturating(0.8, view)).collect()),
        skill: Some((rate - 0.32) / 0.48),
        coverage_auc_views: Some(0.5 + 0.5 * rate),
        coverage_auc_time: Some(0.4 + 0.5 * rate),
        coverage_auc_horizon_s: Some(60.0),
        ..ScanRecord::default()
    };
    record.set_cloud(Some(QualityMm {
        accuracy_mean_mm: 0.9 - rate,
        accuracy_median_mm: 0.7 - rate,
        accuracy_p95_mm: 2.0 - rate,
        completeness_1mm: 0.5 + 0.5 * rate,
        completeness_2mm: 0.6 + 0.5 * rate,
        completeness_5mm: 0.7 + 0.4 * rate,
        completeness_mean_mm: 1.5 - rate,
        f_score_1mm: Some(0.5 + 0.4 * rate),
        f_score_2mm: Some(0.6 + 0.5 * rate),
        f_score_5mm: Some(0.7 + 0.4 * rate),
        chamfer_mm: Some(1.2 - rate),
        ..QualityMm::default()
    }));
    RunRecord {
        object: object.to_owned(),
        data_set: data_set.to_owned(),
        variant: variant.to_owned(),
        seed: 0,
        view_seed: 0,
        first_view: 0,
        config,
        build: BuildIdentity { version: "0.0.0".to_owned(), source: "made-up".to_owned() },
        host: Host { name: "desk".to_owned(), cpu: "Abacus 3000".to_owned(), n_threads: 2 },
        result: RunResult::Done(Box::new(DoneRun { record, extra_memory_mb: Some(12.5 + rank as f64) })),
    }
}

fn saturating(rate: f64, view: usize) -> f64 {
    1.0 - (-rate * view as f64).exp()
}

fn step(view: usize, rate: f64) -> StepRecord {
    let coverage = saturating(rate, view);
    StepRecord {
        step: view,
        view: Some(7 * view),
        voxel_size_m: 0.005,
        voxel_coverage: Some(0.95 * coverage),
        false_voxels: Some(3),
        map_precision: Some(0.98),
        map_recall: Some(0.97 * coverage),
        map_iou: Some(0.95 * coverage),
        reachable_coverage: Some(coverage),
        surface_coverage_1mm: Some(0.8 * coverage),
        surface_coverage_2mm: Some(0.9 * coverage),
        surface_coverage_5mm: Some(0.95 * coverage),
        entropy_nats: 5000.0 * (1.0 - 0.7 * coverage),
        entropy_share: 1.0 - 0.7 * coverage,
        path_length_m: 0.45 * (view - 1) as f64,
        trajectory_length_m: 0.5 * (view - 1) as f64,
        trajectory_time_s: (2.5 - rate) * (view - 1) as f64,
        plan_time_ms: if view == 1 { 0.0 } else { 40.0 * rate + view as f64 },
        map_time_ms: 5.0,
        capture_time_ms: 9.0,
        ..StepRecord::default()
    }
}
