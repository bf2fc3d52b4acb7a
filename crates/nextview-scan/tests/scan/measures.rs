//! The measures of map and model in the record of a simulated scan.

use glam::{DQuat, DVec3};
use nextview::Cancel;
use nextview::geometry::Pose;
use nextview::session::StopConfig;
use nextview_model::SurfaceMesh;
use nextview_scan::{
    BoxRule, FrameSource, Measured, NoiseConfig, NoiseModel, PlannerName, RunOptions, ScanConfig, ScanRecord,
    ScanRun, SimulatedObject, Simulation, TableRule, Truth,
};
use nextview_sim::mesh::sample_surface;

fn config(object: &str) -> ScanConfig {
    ScanConfig {
        object: object.to_owned(),
        planner: PlannerName::Random.into(),
        candidates: 16,
        views: Some(4),
        voxel_size_m: Some(0.01),
        ..ScanConfig::default()
    }
}

/// The record of a whole scan, with the quality of cloud and mesh.
fn record(config: &ScanConfig) -> ScanRecord {
    let object = SimulatedObject::new(config).unwrap();
    let truth = config.baselines.then(|| Truth::new(&object, &Cancel::default(), || ()).unwrap());
    let simulation = Simulation::new(&object, config, truth.as_ref());
    let mut run = ScanRun::begin(&simulation, config, RunOptions::default()).unwrap();
    let stop_reason = run.drive(|_| Ok(())).unwrap();
    let scan = run.finish(Some(stop_reason));
    let model = scan.model(config.model).unwrap();
    scan.record(config, Measured::Model(&model)).unwrap()
}

#[test]
fn the_definitions_hold_in_a_record() {
    let record = record(&config("builtin:mug"));
    for step in &record.steps {
        // An exact scan has no false voxel, so the IoU of its map equals the recall.
        assert_eq!((step.false_voxels, step.map_precision), (Some(0), Some(1.0)));
        assert_eq!(step.map_iou, step.map_recall);
        let n_occupied = step.voxel_coverage.unwrap() * record.object_voxels.unwrap() as f64;
        let recall = n_occupied / record.reachable_voxels.unwrap() as f64;
        assert!((step.map_recall.unwrap() - recall).abs() < 1e-12, "all that is seen is reachable");
    }
    for (quality, name) in [(record.cloud().unwrap(), "cloud"), (record.mesh().unwrap(), "mesh")] {
        let p = [quality.precision_1mm, quality.precision_2mm, quality.precision_5mm].map(Option::unwrap);
        let r = [quality.recall_1mm, quality.recall_2mm, quality.recall_5mm].map(Option::unwrap);
        let f = [quality.f_score_1mm, quality.f_score_2mm, quality.f_score_5mm].map(Option::unwrap);
        assert!(p.is_sorted() && r.is_sorted() && p[2] > 0.99, "{name}: {p:?} {r:?}");
        for i in 0..3 {
            assert!((f[i] * (p[i] + r[i]) - 2.0 * p[i] * r[i]).abs() < 1e-12);
        }
        assert!(r[1] >= quality.completeness_2mm, "{name}: what cannot be seen is not missed");
        let both = quality.accuracy_mean_mm + quality.reachable_completeness_mean_mm.unwrap();
        assert!((2.0 * quality.chamfer_mm.unwrap() - both).abs() < 1e-12);
    }
    let curve = record.reachable_coverage_curve().unwrap();
    let mean = curve.iter().sum::<f64>() / 4.0;
    assert!((record.coverage_auc_views.unwrap() - mean).abs() < 1e-12);
    assert_eq!(record.coverage_auc_horizon_s, Some(24.0), "four views of 4 s of motion and 2 s of sensing");
    let over_time = record.coverage_auc_time.unwrap();
    assert!(over_time > 0.0 && over_time < record.reachable_coverage.unwrap());
    assert_eq!(record.alignment_quaternion_xyzw, Some([0.0, 0.0, 0.0, 1.0]));
    assert_eq!((record.alignment_translation_m, record.alignment_moved_mm), (Some([0.0; 3]), Some(0.0)));
}

#[test]
fn a_perfect_scan_has_all_that_can_be_had() {
    let stop = StopConfig { progress: 0.0, ..StopConfig::default() };
    let all = ScanConfig { views: Some(16), stop, ..config("builtin:bracket") };
    let record = record(&all);
    let last = record.steps.last().unwrap();
    assert_eq!((record.views, last.reachable_coverage), (16, Some(1.0)));
    assert!(last.map_recall.unwrap() > 0.95, "but for voxels that later views passed: {:?}", last.map_recall);
    assert!(last.voxel_coverage.unwrap() < last.map_recall.unwrap());
    let cloud = record.cloud().unwrap();
    assert!(cloud.f_score_2mm.unwrap() > 0.98 && cloud.recall_5mm == Some(1.0), "{cloud:?}");
}

#[test]
fn without_the_truth_of_all_candidates_the_reachable_part_is_unknown() {
    let record = record(&ScanConfig { baselines: false, ..config("builtin:mug") });
    let last = record.steps.last().unwrap();
    assert_eq!((last.map_precision, last.map_recall, last.map_iou), (Some(1.0), None, None));
    let cloud = record.cloud().unwrap();
    assert!(cloud.precision_1mm.is_some() && cloud.completeness_2mm > 0.1);
    assert_eq!((cloud.recall_1mm, cloud.f_score_2mm, cloud.chamfer_mm), (None, None, None));
    assert_eq!((record.coverage_auc_views, record.coverage_auc_time), (None, None));
}

#[test]
fn the_record_has_the_box_and_its_rule() {
    let known = record(&config("builtin:mug"));
    assert_eq!((known.box_rule, known.box_margin_factor), (Some(BoxRule::Known), Some(1.1)));
    assert_eq!(known.box_margin_voxels, Some(2.0));
    let [low, high] = [known.box_min_m.unwrap(), known.box_max_m.unwrap()];
    let object = SimulatedObject::new(&config("builtin:mug")).unwrap();
    let side = 1.1 * object.scene.camera().mesh().bounds().longest_side() + 4.0 * known.voxel_size_m;
    assert!((0..3).all(|i| (high[i] - low[i] - side).abs() < 1e-9), "{low:?} {high:?}");
    let mut config = config("builtin:mug");
    config.object_box.rule = BoxRule::Grows;
    let grown = record(&config);
    assert_eq!((grown.box_rule, grown.box_margin_factor), (Some(BoxRule::Grows), Some(1.1)));
    let last = grown.steps.last().unwrap();
    assert_eq!((grown.box_min_m, grown.box_max_m), (last.box_min_m, last.box_max_m));
}

/// Each frame's pose puts the table somewhere else.
#[test]
fn a_table_that_wrong_poses_lift_is_not_in_the_model() {
    let mut config = config("builtin:mug");
    config.size_m = Some(0.15);
    config.views = Some(5);
    config.candidates = 100;
    config.baselines = false;
    config.object_box.rule = BoxRule::Grows;
    config.object_box.table = TableRule::Fit;
    config.noise = NoiseConfig {
        model: NoiseModel::D435i,
        pose_error_mm: 4.0,
        pose_error_deg: 0.3,
        ..NoiseConfig::default()
    };
    let record = record(&config);
    let [cloud, mesh] = [record.cloud(), record.mesh()].map(|quality| quality.unwrap().accuracy_p95_mm);
    assert!(cloud < 9.0 && mesh < 9.0, "95 % of cloud and mesh are within {cloud} and {mesh} mm");
}

/// A model that is right except for a rigid motion, as with registered frames if the first pose is wrong.
#[test]
fn a_consistent_model_beside_the_truth_is_aligned_to_it_once() {
    let measured = |first_pose_is_right| {
        let noise = NoiseConfig { pose_error_mm: 8.0, first_pose_is_right, ..NoiseConfig::default() };
        let config = ScanConfig { noise, baselines: false, ..config("builtin:teapot") };
        let object = SimulatedObject::new(&config).unwrap();
        let truth = object.scene.camera().mesh();
        let wrong = Pose::new(DQuat::from_rotation_x(0.02), DVec3::new(0.008, -0.005, 0.006)).unwrap();
        let moved = truth.transformed(&wrong).unwrap();
        let mesh = SurfaceMesh { vertices: moved.vertices().to_vec(), triangles: moved.triangles().to_vec() };
        let mut record = ScanRecord::default();
        let cloud = sample_surface(&moved, 5000, 1);
        let simulation = Simulation::new(&object, &config, None);
        simulation.evaluator(&config).measure_model(&cloud, Some(&mesh), &mut record);
        record
    };
    let aligned = measured(false);
    let (moved, turned) = (aligned.alignment_moved_mm.unwrap(), aligned.alignment_turned_deg.unwrap());
    assert!(
        (8.0..14.0).contains(&moved) && (turned - 0.02_f64.to_degrees()).abs() < 0.01,
        "{moved} {turned}"
    );
    for quality in [aligned.cloud(), aligned.mesh()].map(Option::unwrap) {
        assert!(quality.accuracy_p95_mm < 0.05, "cloud and mesh are moved alike: {quality:?}");
    }
    let anchored = measured(true);
    assert_eq!((anchored.alignment_moved_mm, anchored.alignment_turned_deg), (Some(0.0), Some(0.0)));
    assert!(
        anchored.cloud().unwrap().accuracy_mean_mm > 2.0 && anchored.mesh().unwrap().accuracy_mean_mm > 2.0
    );
}
