//! Objects far from the origin, and objects in several parts.

use crate::common::Folder;
use glam::DVec3;
use nextview_octomap::Octree;
use nextview_scan::files::Overwrite;
use nextview_scan::{
    BoxRule, MapSummary, ObjectBoxConfig, Results, RunOptions, ScanConfig, ScanRecord, ScanRun, ScanState,
    SimulatedObject, Simulation, begin_results, write_results,
};
use std::fmt::Write as _;
use std::path::Path;

/// Writes balls as one mesh, from strips between parallels; centres and radii in metres.
fn write_balls(path: &Path, balls: &[(DVec3, f64)]) {
    const N: usize = 24;
    let mut text = String::new();
    for (i, &(center, radius)) in balls.iter().enumerate() {
        for (row, column) in (0..=N).flat_map(|row| (0..N).map(move |column| (row, column))) {
            let (polar, around) = (row as f64 / N as f64, 2.0 * column as f64 / N as f64);
            let ((z_sin, z_cos), (sin, cos)) =
                ((polar * std::f64::consts::PI).sin_cos(), (around * std::f64::consts::PI).sin_cos());
            let point = center + radius * DVec3::new(z_sin * cos, z_sin * sin, z_cos);
            writeln!(text, "v {} {} {}", point.x, point.y, point.z).unwrap();
        }
        let vertex = |row: usize, column: usize| 1 + i * (N + 1) * N + row * N + column % N;
        for (row, column) in (0..N).flat_map(|row| (0..N).map(move |column| (row, column))) {
            let [a, b] = [vertex(row, column), vertex(row, column + 1)];
            let [c, d] = [vertex(row + 1, column), vertex(row + 1, column + 1)];
            writeln!(text, "f {a} {c} {d}\nf {a} {d} {b}").unwrap();
        }
    }
    std::fs::write(path, text).unwrap();
}

fn scanned<T>(config: &ScanConfig, with: impl FnOnce(&ScanState<'_>) -> T) -> (ScanRecord, T) {
    let object = SimulatedObject::new(config).unwrap();
    let simulation = Simulation::new(&object, config, None);
    let mut run = ScanRun::begin(&simulation, config, RunOptions::default()).unwrap();
    let stop_reason = run.drive(|_| Ok(())).unwrap();
    let scan = run.finish(Some(stop_reason));
    let with = with(&scan);
    let model = scan.model(config.model).unwrap();
    (scan.record(config, nextview_scan::Measured::Model(&model)).unwrap(), with)
}

fn config(path: &Path, views: usize) -> ScanConfig {
    ScanConfig {
        object: path.to_string_lossy().into_owned(),
        candidates: 100,
        views: Some(views),
        baselines: false,
        ..ScanConfig::default()
    }
}

/// A ball of 0.1 m at 70 m, in voxels of 2 mm: 35,000 voxels from the origin, more than an OctoMap reaches.
#[test]
fn issue_17_an_object_far_away_is_scanned_as_well_as_one_nearby() {
    let folder = Folder::new("far");
    let mut records = Vec::new();
    for far in [0.0, 70.0, 20_000.0] {
        let path = folder.path("ball.obj");
        write_balls(&path, &[(DVec3::new(far, 0.0, 0.0), 0.05)]);
        let config = ScanConfig { voxel_size_m: Some(0.002), ..config(&path, 4) };
        let dir = folder.path(&format!("results-{far}"));
        let (record, faults) = scanned(&config, |scan| {
            let mut results = begin_results(&dir, Overwrite::nothing()).unwrap();
            let Results { faults, .. } = write_results(&mut results, &config, scan).unwrap();
            results.publish().unwrap();
            faults
        });
        assert_eq!(faults, None);
        for name in ["map.ot", "map.bt"] {
            let octree = Octree::read(std::fs::File::open(dir.join(name)).unwrap()).unwrap();
            assert_eq!(octree.origin() != glam::IVec3::ZERO, far > 0.0);
            let [low, high] = MapSummary::new(&octree, None).unwrap().bounds_m.unwrap();
            assert!(low[0] > far - 0.1 && high[0] < far + 0.1, "{low:?} {high:?}");
        }
        records.push(record);
    }
    let [near, others @ ..] = &records[..] else { panic!("three scans") };
    for far in others {
        let coverage = |record: &ScanRecord| record.steps.last().unwrap().voxel_coverage.unwrap();
        assert!((coverage(near) - coverage(far)).abs() < 0.02, "{} {}", coverage(near), coverage(far));
        let (near, far) = (near.mesh().unwrap(), far.mesh().unwrap());
        assert!((near.accuracy_mean_mm - far.accuracy_mean_mm).abs() < 0.01, "{near:?} {far:?}");
        assert!((near.completeness_2mm - far.completeness_2mm).abs() < 0.02, "{near:?} {far:?}");
    }
}

#[test]
fn issue_17_what_cannot_end_well_is_refused_before_the_first_view() {
    let folder = Folder::new("too-far");
    let path = folder.path("ball.obj");
    write_balls(&path, &[(DVec3::new(9e5, 0.0, 0.0), 0.05)]);
    let config = ScanConfig { voxel_size_m: Some(0.002), ..config(&path, 4) };
    let faults = SimulatedObject::new(&config).err().unwrap().to_string();
    assert!(faults.contains("268,435,456 from the origin"), "{faults}");
}

#[test]
fn issue_17_bodies_beside_the_object_are_reported_and_can_belong_to_it() {
    let folder = Folder::new("bodies");
    let path = folder.path("two.obj");
    for distance in [0.15, 0.4] {
        write_balls(&path, &[(DVec3::ZERO, 0.05), (DVec3::new(distance, 0.0, 0.0), 0.04)]);
        let one = ScanConfig {
            object_box: ObjectBoxConfig { rule: BoxRule::Grows, ..ObjectBoxConfig::default() },
            voxel_size_m: Some(0.01),
            ..config(&path, 6)
        };
        let (record, ()) = scanned(&one, |_| ());
        let [body] = record.other_bodies[..] else { panic!("{:?}", record.other_bodies) };
        let gap = distance - 0.09;
        assert!((body.gap_m - gap).abs() < 0.02, "{body:?}, gap {gap}");
        assert!(body.size_m.iter().all(|size| *size < 0.11), "{body:?}");

        let object_box = ObjectBoxConfig { max_gap_m: body.gap_m + 0.01, ..one.object_box };
        let (both, ()) = scanned(&ScanConfig { object_box, ..one }, |_| ());
        assert_eq!(both.other_bodies, []);
        let coverage = |record: &ScanRecord| record.steps.last().unwrap().voxel_coverage.unwrap();
        assert!(coverage(&both) > coverage(&record) + 0.1, "{} {}", coverage(&both), coverage(&record));
    }
}

#[test]
fn a_single_object_has_no_other_bodies() {
    for object in ["builtin:teapot", "builtin:mug"] {
        let config = ScanConfig {
            object_box: ObjectBoxConfig { rule: BoxRule::Grows, ..ObjectBoxConfig::default() },
            voxel_size_m: Some(0.01),
            ..config(Path::new(object), 5)
        };
        assert_eq!(scanned(&config, |_| ()).0.other_bodies, []);
    }
}
