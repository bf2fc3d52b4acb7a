//! Campaigns that never happened.

use super::campaign::{Campaign, key};
use crate::bench::{Host, Measures, RunRecord, RunResult, StepMeasures};
use crate::scan::{PlannerName, Profile, QualityMm, ScanConfig};
use nextview::session::StopReason;
use std::path::PathBuf;

const OBJECTS: [(&str, &str); 6] = [
    ("builtin", "mug"),
    ("lm", "lm_obj_000004_camera"),
    ("lm", "lm_obj_000006_cat"),
    ("lm", "lm_obj_000013_iron"),
    ("stanford", "bunny"),
    ("stanford", "happy_buddha"),
];

/// The planner of each variant by its name: APORA, RSE or random for these, or else max-flow.
fn planner(variant: &str) -> PlannerName {
    match variant {
        "apora" => PlannerName::Apora,
        "rse" => PlannerName::Rse,
        "random" => PlannerName::Random,
        _ => PlannerName::MaxFlow,
    }
}

/// A campaign of these variants, the later the better, on the first few of six objects.
pub(crate) fn campaign(variants: &[&str], n_objects: usize) -> Campaign {
    let runs = variants.iter().enumerate().flat_map(|(i, variant)| {
        OBJECTS[..n_objects].iter().enumerate().map(move |(j, object)| run(variant, *object, i, j))
    });
    let mut runs: Vec<RunRecord> = runs.collect();
    runs.sort_by_key(key);
    Campaign { name: "made-up".to_owned(), runs, torn: false }
}

/// The measures of a run, to change them.
pub(crate) fn measures_mut(run: &mut RunRecord) -> &mut Measures {
    match &mut run.result {
        RunResult::Done(measures) => measures,
        RunResult::Failed(reason) => panic!("{reason}"),
    }
}

/// An empty folder.
pub(crate) fn folder(name: &str) -> PathBuf {
    let folder = std::env::temp_dir().join(format!("nextview-study-{name}-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    folder
}

fn run(variant: &str, (data_set, object): (&str, &str), rank: usize, object_idx: usize) -> RunRecord {
    let config = ScanConfig {
        object: format!("meshes/{object}.ply"),
        planner: planner(variant),
        voxel_size_m: Some(0.005),
        ..ScanConfig::of_profile(Profile::Default)
    };
    let rate = 0.3 + 0.08 * rank as f64 + 0.02 * (object_idx * (rank + 2) % 5) as f64;
    let measures = Measures {
        n_object_voxels: 1000,
        n_reachable: Some(960),
        stop_reason: StopReason::ViewLimit,
        steps: (1..=config.views).map(|view| step(view, rate)).collect(),
        random_curve: Some((1..=config.views).map(|view| saturating(0.32, view)).collect()),
        clairvoyant_curve: Some((1..=config.views).map(|view| saturating(0.8, view)).collect()),
        skill: Some((rate - 0.32) / 0.48),
        cloud: Some(QualityMm {
            accuracy_mean_mm: 0.9 - rate,
            accuracy_median_mm: 0.7 - rate,
            accuracy_p95_mm: 2.0 - rate,
            completeness_1mm: 0.5 + 0.5 * rate,
            completeness_2mm: 0.6 + 0.5 * rate,
            completeness_5mm: 0.7 + 0.4 * rate,
            completeness_mean_mm: 1.5 - rate,
        }),
        extra_memory_mb: Some(12.5 + rank as f64),
    };
    RunRecord {
        object: object.to_owned(),
        data_set: data_set.to_owned(),
        variant: variant.to_owned(),
        seed: 0,
        first_view: 0,
        config,
        version: "0.0.0".to_owned(),
        host: Host { name: "desk".to_owned(), cpu: "Abacus 3000".to_owned(), n_threads: 2 },
        result: RunResult::Done(Box::new(measures)),
    }
}

fn saturating(rate: f64, view: usize) -> f64 {
    1.0 - (-rate * view as f64).exp()
}

fn step(view: usize, rate: f64) -> StepMeasures {
    let seen = saturating(rate, view);
    StepMeasures {
        view: Some(7 * view),
        voxel_size_m: 0.005,
        voxel_coverage: 0.95 * seen,
        false_voxels: 3,
        seen: Some(seen),
        estimated_seen_before: None,
        expected_new_voxels: None,
        surface_1mm: 0.8 * seen,
        surface_2mm: 0.9 * seen,
        surface_5mm: 0.95 * seen,
        misplaced_mm: None,
        registration: None,
        overlap: None,
        entropy_nats: 5000.0 * (1.0 - 0.7 * seen),
        entropy_share: 1.0 - 0.7 * seen,
        path_length_m: 0.45 * (view - 1) as f64,
        way_m: Some(0.5 * (view - 1) as f64),
        move_time_s: Some((2.5 - rate) * (view - 1) as f64),
        plan_time_ms: if view == 1 { 0.0 } else { 40.0 * rate + view as f64 },
        map_time_ms: 5.0,
        render_time_ms: 9.0,
    }
}
