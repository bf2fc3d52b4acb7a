//! Synthetic runs for tests, here and in `nextview-report`.

use super::{DoneRun, Host, RunRecord, RunResult};
use nextview::session::StopReason;
use nextview_scan::{BuildIdentity, PlannerName, Profile, QualityMm, ScanConfig, ScanRecord, StepRecord};

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

/// Synthetic runs of these variants, each better than the one before, on the first `n_objects` of six
/// objects; sorted by identity.
pub(crate) fn campaign(variants: &[&str], n_objects: usize) -> Vec<RunRecord> {
    let of_variant = |(i, variant): (usize, &&str)| -> Vec<RunRecord> {
        OBJECTS[..n_objects].iter().zip(0..).map(|(object, j)| run(variant, *object, i, j)).collect()
    };
    let mut runs: Vec<RunRecord> = variants.iter().enumerate().flat_map(of_variant).collect();
    runs.sort_by_key(RunRecord::id);
    runs
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
        build: BuildIdentity::this(),
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
