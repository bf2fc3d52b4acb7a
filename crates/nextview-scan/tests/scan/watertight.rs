//! Closed meshes of whole scans.

use crate::common::meshes;
use glam::DVec3;
use nextview_model::SurfaceMesh;
use nextview_scan::{
    BoxRule, FinalModel, Measured, ModelConfig, NoiseConfig, NoiseModel, RunOptions, ScanConfig, ScanRecord,
    ScanRun, SimulatedObject, Simulation, TableRule,
};
use nextview_sim::mesh::{Unit, load};
use std::collections::BTreeSet;

/// Ten noisy views of an object on a table; the place of both is unknown.
fn config(object: String, size_m: f64) -> ScanConfig {
    ScanConfig {
        object,
        size_m: Some(size_m),
        baselines: false,
        noise: NoiseConfig { model: NoiseModel::D435i, ..NoiseConfig::default() },
        object_box: nextview_scan::ObjectBoxConfig {
            rule: BoxRule::Grows,
            table: TableRule::Fit,
            ..nextview_scan::ObjectBoxConfig::default()
        },
        model: ModelConfig { watertight: true },
        ..ScanConfig::default()
    }
}

fn scan(config: &ScanConfig) -> (ScanRecord, FinalModel) {
    let object = SimulatedObject::new(config).unwrap();
    let simulation = Simulation::new(&object, config, None);
    let mut run = ScanRun::begin(&simulation, config, RunOptions::default()).unwrap();
    let stop_reason = run.drive(|_| Ok(())).unwrap();
    let scan = run.finish(Some(stop_reason));
    let model = scan.model(config.model).unwrap();
    (scan.record(config, Measured::Model(&model)).unwrap(), model)
}

fn volume(vertices: &[DVec3], triangles: &[[u32; 3]]) -> f64 {
    let corners = triangles.iter().map(|t| t.map(|i| vertices[i as usize]));
    corners.map(|[a, b, c]| a.dot(b.cross(c)) / 6.0).sum()
}

/// Each edge belongs to two triangles, which use it in opposite directions.
fn assert_closed(mesh: &SurfaceMesh) {
    let edges = |&[a, b, c]: &[u32; 3]| [(a, b), (b, c), (c, a)];
    let all: Vec<(u32, u32)> = mesh.triangles.iter().flat_map(edges).collect();
    let distinct: BTreeSet<(u32, u32)> = all.iter().copied().collect();
    assert!(!all.is_empty() && all.len() == distinct.len());
    assert!(distinct.iter().all(|&(a, b)| distinct.contains(&(b, a))));
}

/// The measures of the mesh are those of its measured part.
fn check_closed(record: &ScanRecord, model: &FinalModel) {
    let closed = model.closed.as_ref().unwrap();
    assert_closed(&closed.mesh);
    assert!(volume(&closed.mesh.vertices, &closed.mesh.triangles) > 0.0);
    assert_eq!(model.mesh, closed.measured());
    assert_eq!(model.triangles(), closed.mesh.triangles);
    assert_eq!(record.mesh_filled_share, Some(closed.filled_share()));
    assert!(record.mesh().is_some());
}

#[test]
fn a_scanned_mug_is_closed_if_wanted() {
    let wanted = ScanConfig { views: Some(3), candidates: 60, ..config("builtin:mug".to_owned(), 0.1) };
    let (record, model) = scan(&wanted);
    check_closed(&record, &model);
    assert!(record.mesh_filled_share.unwrap() > 0.05, "the bottom was never seen");
    let open = ScanConfig { model: ModelConfig::default(), ..wanted };
    let (record, model) = scan(&open);
    assert_eq!((record.mesh_filled_share, model.closed), (None, None));
}

#[test]
fn real_objects_are_closed_and_keep_their_volume() {
    let Some(data) = meshes("real_objects_are_closed_and_keep_their_volume") else { return };
    // A mug and a part with holes have insides that views do not reach: only check that the mesh is closed.
    for (name, tolerance) in [
        ("lm/lm_obj_000009_duck.ply", Some(0.04)),
        ("other/ikea_mug.ply", None),
        ("tless/tless_05.ply", None),
    ] {
        let path = data.join(name);
        let (record, model) = scan(&config(path.display().to_string(), 0.15));
        check_closed(&record, &model);
        let (truth, _) = load(&path).unwrap().to_metres(Unit::LongestSide(0.15)).unwrap();
        let closed = model.closed.unwrap().mesh;
        let share = volume(&closed.vertices, &closed.triangles) / volume(truth.vertices(), truth.triangles());
        println!("{name}: {share:.3} of the volume");
        assert!(tolerance.is_none_or(|tolerance| (share - 1.0).abs() < tolerance), "{name}: {share}");
    }
}
