//! An arm that holds the camera: it moves to each view, and its motions are in the results.

use crate::common::Folder;
use glam::DVec3;
use nextview::Cancel;
use nextview::geometry::Pose;
use nextview::session::StopReason;
use nextview_scan::{
    FrameSource, Next, ObjectBoxConfig, RobotConfig, RunOptions, ScanConfig, ScanRun, SimulatedObject,
    Simulation, TableRule, result_file,
};

/// A UR5e next to a mug on a table, with the camera 5 cm in front of its flange.
fn config() -> ScanConfig {
    let mut robot = RobotConfig {
        flange_from_camera: Pose::new(glam::DQuat::IDENTITY, DVec3::Z * 0.05).unwrap(),
        ..RobotConfig::default()
    };
    robot.set_base(DVec3::new(-0.55, 0.0, 0.0)).unwrap();
    ScanConfig {
        object: "builtin:mug".to_owned(),
        candidates: 60,
        views: Some(4),
        voxel_size_m: Some(0.01),
        baselines: false,
        object_box: ObjectBoxConfig { table: TableRule::Known, ..ObjectBoxConfig::default() },
        robot: Some(robot),
        ..ScanConfig::default()
    }
}

#[test]
fn the_camera_is_where_the_joints_hold_it() {
    let config = config();
    let cell = config.robot.as_ref().unwrap().cell().unwrap();
    let object = SimulatedObject::new(&config).unwrap();
    assert!(object.views.len() < 60, "{} within reach", object.views.len());
    assert!(object.notes().iter().any(|note| note.contains("the robot can hold the camera at")));
    let source = Simulation::new(&object, &config, None);
    let mut run = ScanRun::begin(&source, &config, RunOptions::default()).unwrap();
    let reason = run.drive(|_| Ok(())).unwrap();
    assert_eq!((reason, run.steps().len()), (StopReason::ViewLimit, 4));
    let scan = run.finish(Some(reason));
    let mut at: Option<Vec<f64>> = None;
    for (i, step) in scan.steps.iter().enumerate() {
        let values = step.joint_values.clone().unwrap();
        let held = cell.world_from_camera(&values);
        assert!(held.translation().distance(DVec3::from_array(step.position_m)) < 1e-6);
        let (joints, camera) = (scan.joint_trajectories[i].as_ref().unwrap(), &scan.trajectories[i]);
        assert_eq!(joints.points.last().unwrap().1, values);
        assert!(at.is_none_or(|at| at == joints.points[0].1), "the arm begins where it was");
        assert_eq!((camera.waypoints().len(), camera.duration()), (joints.points.len(), joints.duration()));
        for ((time, values), waypoint) in joints.points.iter().zip(camera.waypoints()) {
            assert!(cell.arm().is_within_limits(values) && *time == waypoint.time);
            let held = cell.world_from_camera(values).translation();
            assert!(held.distance(waypoint.world_from_camera.translation()) < 1e-12);
        }
        at = Some(values);
    }
    let csv = String::from_utf8(result_file("waypoints.csv", &config, &scan).unwrap()).unwrap();
    let n_columns = 9 + cell.arm().n_joints();
    assert!(csv.lines().all(|line| line.split(',').count() == n_columns), "{csv}");
}

#[test]
fn the_same_scan_after_an_interruption() {
    let (config, folder) = (config(), Folder::new("robot"));
    let object = SimulatedObject::new(&config).unwrap();
    let source = Simulation::new(&object, &config, None);
    let views = |run: &ScanRun<'_>| -> Vec<_> {
        run.steps().iter().map(|step| (step.view, step.joint_values.clone())).collect()
    };
    let journal = || Some(nextview_scan::ScanJournal::begin(&folder.path("scan"), "").unwrap());
    let mut whole = ScanRun::begin(&source, &config, RunOptions::default()).unwrap();
    whole.drive(|_| Ok(())).unwrap();

    let mut run =
        ScanRun::begin(&source, &config, RunOptions { journal: journal(), cancel: Cancel::default() })
            .unwrap();
    let cancel = run.session().cancel().clone();
    let mut n = 0;
    run.drive(|_| {
        n += 1;
        if n == 2 {
            cancel.cancel();
        }
        Ok(())
    })
    .unwrap();
    drop(run);
    let journal = nextview_scan::ScanJournal::resume(&folder.path("scan")).unwrap().journal;
    let begin = RunOptions { journal: Some(journal), cancel: Cancel::default() };
    let mut resumed = ScanRun::begin(&source, &config, begin).unwrap();
    resumed.drive(|_| Ok(())).unwrap();
    assert_eq!(views(&resumed), views(&whole));
}

/// If the arm is moved by hand, the frame comes from somewhere else: the next motion begins there.
#[test]
fn the_arm_is_where_the_frame_was_taken() {
    let config = config();
    let cell = config.robot.as_ref().unwrap().cell().unwrap();
    let object = SimulatedObject::new(&config).unwrap();
    let source = Simulation::new(&object, &config, None);
    let mut run = ScanRun::begin(&source, &config, RunOptions::default()).unwrap();
    let Next::Capture(mut view) = run.next().unwrap() else { panic!("begins") };
    let far = |pose: &&Pose| pose.translation().distance(view.world_from_camera.translation()) > 0.2;
    let elsewhere = *object.views.poses().iter().find(far).unwrap();
    view.world_from_camera = elsewhere;
    run.push(source.capture(&view, true).unwrap().frame).unwrap();
    let values = run.steps()[0].joint_values.clone().unwrap();
    assert!(cell.world_from_camera(&values).translation().distance(elsewhere.translation()) < 1e-6);
}

#[test]
fn an_arm_out_of_reach_says_so() {
    let mut config = config();
    config.robot.as_mut().unwrap().set_base(DVec3::X * 5.0).unwrap();
    let fault = format!("{:?}", SimulatedObject::new(&config).err().unwrap());
    assert!(
        fault.contains("cannot hold the camera at any of the") && fault.contains("robot.world_from_base"),
        "{fault}"
    );
}

#[test]
fn a_base_within_the_object_is_refused() {
    let mut config = config();
    config.robot.as_mut().unwrap().set_base(DVec3::ZERO).unwrap();
    let fault = SimulatedObject::new(&config).err().unwrap().to_string();
    assert!(fault.contains("robot.world_from_base") && fault.contains("outside the object's box"), "{fault}");
}

#[test]
fn what_is_no_robot_is_refused() {
    let of = |change: &dyn Fn(&mut RobotConfig)| {
        let mut robot = RobotConfig::default();
        change(&mut robot);
        ScanConfig { robot: Some(robot), ..config() }.check_with_files().unwrap_err().to_string()
    };
    let wrong = [
        (of(&|robot| robot.arm = "ur55".to_owned()), "ur55: cannot be read"),
        (of(&|robot| robot.home = vec![0.0; 5]), "robot.home"),
        (of(&|robot| robot.home = vec![99.0; 6]), "robot.home"),
        (of(&|robot| robot.clearance_m = 0.0), "clearance_m"),
        (of(&|robot| robot.boxes_m = vec![[1.0; 6]]), "robot.boxes_m"),
        (of(&|robot| robot.camera_body_m = [0.0; 6]), "robot.camera_body_m"),
        (of(&|robot| robot.base_from_camera = Some(Pose::IDENTITY)), "robot.flange_from_world"),
    ];
    for (message, expected) in wrong {
        assert!(message.contains(expected), "{message}");
    }
}
