//! A simulated scan through the library, from the configuration to the folder.

use crate::common::{Folder, meshes};
use glam::DVec3;
use nextview::Cancel;
use nextview::geometry::{Aabb, Pose};
use nextview::registration::RegistrationMode;
use nextview::sensor::ColorImage;
use nextview::session::{NextView, Session};
use nextview_scan::files::Overwrite;
use nextview_scan::{
    BoxRule, Captured, Evaluator, Fault, Faults, FrameSource, Measured, Next, NoiseModel, PlannerName,
    Results, RunOptions, ScanConfig, ScanRecord, ScanRun, ScanState, SimulatedObject, Simulation, SizeOf,
    StepRecord, TableRule, Truth, ViewSpaceName, begin_results, write_results,
};

fn config() -> ScanConfig {
    ScanConfig {
        object: "builtin:mug".to_owned(),
        planner: PlannerName::MaxFlow.into(),
        candidates: 20,
        views: Some(4),
        voxel_size_m: Some(0.01),
        ..ScanConfig::default()
    }
}

fn scanned<'a>(source: &'a dyn FrameSource, config: &ScanConfig) -> ScanState<'a> {
    let mut run = ScanRun::begin(source, config, RunOptions::default()).unwrap();
    let stop_reason = run.drive(|_| Ok(())).unwrap();
    run.finish(Some(stop_reason))
}

#[test]
fn a_scan_is_measured_and_written() {
    let config = config();
    let object = SimulatedObject::new(&config).unwrap();
    let truth = Truth::new(&object, &Cancel::default(), || ()).unwrap();
    let simulation = Simulation::new(&object, &config, Some(&truth));
    let scan = scanned(&simulation, &config);
    let folder = Folder::new("simulation");
    let dir = folder.path("results");
    let mut results = begin_results(&dir, Overwrite::nothing()).unwrap();
    let Results { record, faults } = write_results(&mut results, &config, &scan).unwrap();
    assert_eq!(faults, None);
    assert_eq!((record.views, record.steps.len(), record.candidates), (4, 4, 20));
    assert_eq!(record.reachable_coverage, record.steps[3].reachable_coverage);
    assert!(record.reachable_coverage.unwrap() > 0.5 && record.skill.is_some());
    assert!(record.cloud().unwrap().accuracy_mean_mm < 0.1 && record.mesh().unwrap().completeness_5mm > 0.3);

    results.publish().unwrap();
    let read: ScanRecord = serde_json::from_slice(&std::fs::read(dir.join("record.json")).unwrap()).unwrap();
    assert_eq!(read, record);
    let steps = std::fs::read_to_string(dir.join("steps.jsonl")).unwrap();
    assert_eq!(steps.lines().count(), 4);
}

#[test]
fn objects_and_candidates_are_where_the_protocols_of_others_want_them() {
    let config = ScanConfig {
        size_m: Some(0.1),
        size_of: SizeOf::Radius,
        view_space: ViewSpaceName("tammes".to_owned()),
        view_distance_m: Some(0.3),
        voxel_size_m: None,
        ..config()
    };
    let object = SimulatedObject::new(&config).unwrap();
    let mesh = object.scene.camera().mesh();
    let corners = (0..mesh.triangles().len()).flat_map(|triangle| mesh.corners(triangle));
    let radius = corners.map(|corner| corner.length()).fold(0.0, f64::max);
    assert!((radius - 0.1).abs() < 1e-12 && mesh.centroid().length() < 1e-12);
    assert!(mesh.bounds().center().length() > 0.001, "its handle is on one side");
    let looks_at_origin = |pose: &Pose, distance: f64| {
        let position = pose.translation();
        let axis = pose.rotation() * DVec3::Z;
        (position.length() - distance).abs() < 1e-9 && axis.dot(-position / distance) > 1.0 - 1e-9
    };
    assert!(object.views.poses().iter().all(|pose| looks_at_origin(pose, 0.3)));

    let config = ScanConfig {
        size_m: Some(0.3),
        size_of: SizeOf::ShortestSide,
        view_space: ViewSpaceName("rings".to_owned()),
        view_distance_m: None,
        view_standoff_m: Some(0.696),
        ..config
    };
    let object = SimulatedObject::new(&config).unwrap();
    let bounds = *object.scene.bounds();
    assert!((bounds.size().min_element() - 0.3).abs() < 1e-12 && bounds.center().length() < 1e-12);
    let distance = 0.5 * bounds.size().length() + 0.696;
    assert!(object.views.poses().iter().all(|pose| looks_at_origin(pose, distance)));
}

#[test]
fn a_scan_under_way_has_a_record() {
    let config = ScanConfig { baselines: false, ..config() };
    let object = SimulatedObject::new(&config).unwrap();
    let simulation = Simulation::new(&object, &config, None);
    let run = ScanRun::begin(&simulation, &config, RunOptions::default()).unwrap();
    let record = run.finish(None).record(&config, Measured::CloudOnly).unwrap();
    assert_eq!((record.stop_reason, record.views, record.cloud()), (None, 0, None));
}

#[test]
fn pushed_by_hand_it_is_the_same_as_driven() {
    let config = ScanConfig { baselines: false, ..config() };
    let object = SimulatedObject::new(&config).unwrap();
    let (by_hand, driven) =
        (Simulation::new(&object, &config, None), Simulation::new(&object, &config, None));
    let mut run = ScanRun::begin(&by_hand, &config, RunOptions::default()).unwrap();
    while let Next::Capture(view) = run.next().unwrap() {
        let captured = by_hand.capture(&view, run.steps().is_empty()).unwrap();
        run.push(captured.frame).unwrap();
    }
    let expected = scanned(&driven, &config);
    let views = |steps: &[StepRecord]| steps.iter().map(|step| step.view).collect::<Vec<_>>();
    assert_eq!(views(run.steps()), views(&expected.steps));
    assert_eq!(run.session().map().voxels(), expected.session.map().voxels());
}

#[test]
fn the_baselines_can_be_cancelled() {
    let object = SimulatedObject::new(&config()).unwrap();
    let cancel = Cancel::default();
    cancel.cancel();
    assert!(Truth::new(&object, &cancel, || panic!("nothing is looked at")).is_err());
}

#[test]
fn without_the_truth_there_is_no_clairvoyant_planner() {
    let config = ScanConfig { planner: PlannerName::Clairvoyant.into(), ..config() };
    let object = SimulatedObject::new(&config).unwrap();
    let simulation = Simulation::new(&object, &config, None);
    let Err(faults) = ScanRun::begin(&simulation, &config, RunOptions::default()) else {
        panic!("it needs the truth")
    };
    assert!(faults.to_string().contains("needs the true object"));
}

/// A simulation whose colour images cannot be loaded.
struct WithoutColor<'a>(Simulation<'a>);

impl FrameSource for WithoutColor<'_> {
    fn session(&self, config: &ScanConfig) -> Result<Session, Faults> {
        self.0.session(config)
    }

    fn capture(&self, next: &NextView, is_first: bool) -> Result<Captured, Fault> {
        self.0.capture(next, is_first)
    }

    fn color(&self, next: &NextView) -> Result<Option<ColorImage>, Fault> {
        Err(Fault::data(format!("no colour of view {:?}", next.view)))
    }

    fn bounds(&self) -> Option<Aabb> {
        self.0.bounds()
    }

    fn evaluator(&self, config: &ScanConfig) -> Box<dyn Evaluator + '_> {
        self.0.evaluator(config)
    }
}

#[test]
fn all_is_written_but_what_fails() {
    let config = ScanConfig { baselines: false, ..config() };
    let object = SimulatedObject::new(&config).unwrap();
    let source = WithoutColor(Simulation::new(&object, &config, None));
    let scan = scanned(&source, &config);
    let folder = Folder::new("incomplete");
    let dir = folder.path("results");
    let mut results = begin_results(&dir, Overwrite::nothing()).unwrap();
    let Results { record, faults } = write_results(&mut results, &config, &scan).unwrap();
    results.publish().unwrap();
    let faults = faults.unwrap().to_string();
    assert_eq!(faults, "cloud and mesh: no colour of view Some(0)\nframes: no colour of view Some(0)");
    assert!(record.views == 4 && record.cloud().is_none());
    let mut names: Vec<String> = std::fs::read_dir(&dir)
        .unwrap()
        .map(|entry| entry.unwrap().file_name().to_string_lossy().into_owned())
        .collect();
    names.sort();
    let whole = [
        "config.toml",
        "frames",
        "map.bt",
        "map.ot",
        "record.json",
        "steps.jsonl",
        "views.csv",
        "waypoints.csv",
    ];
    assert_eq!(names, whole);
    assert!(dir.join("frames/depth/004.png").is_file() && !dir.join("frames/color").exists());
}

/// The warnings of four frames of a mug on a table, with the noise of a D435i and poses off by `error_mm`.
fn warnings(error_mm: f64, mode: RegistrationMode) -> Vec<String> {
    warnings_in(&steps_of(&noisy_mug(error_mm, mode)))
}

fn noisy_mug(error_mm: f64, mode: RegistrationMode) -> ScanConfig {
    let mut config = ScanConfig {
        size_m: Some(0.1),
        voxel_size_m: None,
        candidates: 100,
        baselines: false,
        planner: PlannerName::MostSurface.into(),
        ..config()
    };
    config.noise.model = NoiseModel::D435i;
    config.noise.pose_error_mm = error_mm;
    config.noise.pose_error_deg = 0.1 * error_mm;
    config.object_box.table = TableRule::Known;
    config.registration.enabled = Some(mode);
    config
}

fn warnings_in(steps: &[StepRecord]) -> Vec<String> {
    steps.iter().filter_map(|step| step.warning.clone()).collect()
}

fn steps_of(config: &ScanConfig) -> Vec<StepRecord> {
    let object = SimulatedObject::new(config).unwrap();
    let simulation = Simulation::new(&object, config, None);
    scanned(&simulation, config).record(config, Measured::Nothing).unwrap().steps
}

#[test]
fn poses_that_do_not_agree_with_the_frames_are_named_and_right_ones_are_not() {
    let [found] = &warnings(10.0, RegistrationMode::Off)[..] else { panic!("one warning") };
    assert!(found.contains(" mm apart; `registration.enabled` = true aligns"), "{found}");
    assert_eq!(warnings(0.0, RegistrationMode::Off), Vec::<String>::new());
    assert_eq!(warnings(10.0, RegistrationMode::On), Vec::<String>::new());
}

#[test]
fn wrong_poses_are_found_out_and_all_frames_are_aligned() {
    let steps = steps_of(&noisy_mug(2.0, RegistrationMode::Auto));
    let [found] = &warnings_in(&steps)[..] else { panic!("one warning, once") };
    assert!(found.ends_with(" mm apart; from now on, all frames are aligned to each other"), "{found}");
    assert!(steps[0].registration_verdict.is_none() && steps[3].registration_verdict.is_some());
}

/// Alignment moves frames by less than the map notices; their points are in other cells then.
#[test]
fn bodies_are_told_apart_though_aligned_frames_have_moved() {
    for max_gap_m in [0.0, 0.01] {
        let mut config = noisy_mug(1.5, RegistrationMode::On);
        config.object_box.rule = BoxRule::Grows;
        config.object_box.table = TableRule::Fit;
        config.object_box.max_gap_m = max_gap_m;
        let object = SimulatedObject::new(&config).unwrap();
        let simulation = Simulation::new(&object, &config, None);
        assert_eq!(scanned(&simulation, &config).session.other_bodies().unwrap(), []);
    }
}

#[test]
fn right_poses_stay_to_the_bit_where_frames_are_aligned_once_poses_prove_wrong() {
    let shown = |mode| -> Vec<_> {
        let steps = steps_of(&noisy_mug(0.0, mode)).into_iter();
        steps
            .map(|step| (step.view, step.world_from_camera(), step.entropy_nats.to_bits(), step.warning))
            .collect()
    };
    assert_eq!(shown(RegistrationMode::Auto), shown(RegistrationMode::Off));
}

#[test]
fn frames_that_cannot_be_aligned_are_used_as_given() {
    let shown = |mode| {
        let mut config = noisy_mug(5.0, mode);
        config.views = Some(9);
        // Its views do not depend on the map.
        config.planner = PlannerName::InOrder.into();
        // Hardly any alignment is that near.
        config.registration.position_uncertainty = 0.0005;
        let steps = steps_of(&config);
        let map: Vec<_> = steps.iter().map(|step| (step.view, step.world_from_camera())).collect();
        (warnings_in(&steps), map, steps[8].entropy_nats.to_bits())
    };
    let (warnings, poses, entropy) = shown(RegistrationMode::Auto);
    let last = warnings.last().map(String::as_str);
    assert_eq!(last, Some("most frames cannot be aligned to each other: all poses are used as given"));
    let (_, given_poses, as_given) = shown(RegistrationMode::Off);
    assert_eq!((poses, entropy), (given_poses, as_given));
}

/// One face of the brick fits well on the next.
#[test]
fn right_poses_around_a_brick_agree_with_the_frames() {
    let Some(meshes) = meshes("right_poses_around_a_brick_agree_with_the_frames") else { return };
    let mut config = ScanConfig::parse(
        "unit = 'm'\nviews = 4\ncandidates = 300\nbaselines = false\nsensor = 'd405'\nview_space = 'hemisphere'\n\
         object_box.table = 'known'\n",
        None,
        None,
    )
    .unwrap();
    config.object = meshes.join("ycb/ycb_061_foam_brick.ply").display().to_string();
    assert_eq!(warnings_in(&steps_of(&config)), Vec::<String>::new());
}

#[test]
fn one_triangle_is_no_plural() {
    let folder = Folder::new("one-triangle");
    let path = folder.path("flat.obj");
    std::fs::write(&path, "v 0 0 0\nv 0.08 0 0\nv 0 0.08 0\nf 1 2 3\n").unwrap();
    let config = ScanConfig { object: path.display().to_string(), candidates: 9, ..config() };
    let object = SimulatedObject::new(&config).unwrap();
    assert_eq!(object.description(), "flat: 80 x 80 x 0 mm, 1 triangle");
}
