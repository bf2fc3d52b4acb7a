//! Recordings of real cameras, where there are any.

use nextview::geometry::Aabb;
use nextview::sensor::Depth;
use nextview_checks::data;
use nextview_recording::{ReadOptions, Recording, read_transform};
use nextview_sim::mesh::{self, Unit};
use nextview_sim::surface::SurfaceCoverage;

#[test]
fn a_primesense_looks_at_the_bunny() {
    let test = "a_primesense_looks_at_the_bunny";
    let Some(path) = data(test, "rgbd/bunny_primesense") else { return };
    let Some(mesh) = data(test, "meshes/stanford/bunny.ply") else { return };
    let several = Recording::open(&path, &ReadOptions::default()).unwrap_err().to_string();
    assert!(
        several.contains("poses.csv: line 1: there are several sets of pose columns, given, refined"),
        "{several}"
    );

    let options = ReadOptions { pose_columns: Some("given".into()), ..ReadOptions::default() };
    let recording = Recording::open(&path, &options).unwrap();
    assert_eq!((recording.frames.len(), recording.skipped.len()), (36, 0));
    assert!(recording.notes[0].contains("scale or shear of up to 0.7 %"), "{:?}", recording.notes);

    // Colour shows the white bunny: bright, and hardly coloured.
    let color = recording.frames[7].load_color().unwrap().unwrap();
    let image = recording.frames[7].load().unwrap().image().clone();
    let pixels = (0..480).flat_map(|v| (0..640).map(move |u| (u, v)));
    let on_it = pixels.filter(|&(u, v)| matches!(image.get(u, v), Depth::Surface(_)));
    let colors: Vec<[f64; 3]> = on_it.map(|(u, v)| color.get(u, v).map(f64::from)).collect();
    let [red, green, blue] =
        [0, 1, 2].map(|i| colors.iter().map(|c| c[i]).sum::<f64>() / colors.len() as f64);
    println!("mean colour of the bunny: {red:.0} {green:.0} {blue:.0}");
    assert!([red, green, blue].iter().all(|value| *value > 100.0 && (value - green).abs() < 40.0));

    // The true shape, seen from the world of the recording, lies where the points are.
    let truth_from_world = read_transform(&path.join("T_mesh_world.txt")).unwrap();
    let (mesh, _) = mesh::load(&mesh).unwrap().to_metres(Unit::Auto).unwrap();
    let mut coverage = SurfaceCoverage::new(&mesh.transformed(&truth_from_world.inverse()).unwrap());
    recording.frames.iter().for_each(|frame| coverage.add(&frame.load().unwrap()));
    let share = coverage.share_within(0.002);
    println!("{share:.3} of the true surface have a measured point within 2 mm");
    assert!((0.5..0.95).contains(&share), "the ring of views shows much, but not all: {share}");
}

#[test]
fn a_kinect_looks_at_a_room() {
    let Some(path) = data("a_kinect_looks_at_a_room", "rgbd/redkitchen_kinect") else { return };
    let recording = Recording::open(&path, &ReadOptions::default()).unwrap();
    assert_eq!((recording.frames.len(), recording.skipped.len()), (50, 0));
    let frame = recording.frames[7].load().unwrap();
    assert!(frame.points_in(Aabb::cube(frame.world_from_camera().translation(), 6.0)).count() > 100_000);
}
