//! Whatever the form, the map is the same.

use crate::mcap::{Form, bytes};
use crate::synthetic::{Folder, SyntheticRecording};
use glam::IVec3;
use nextview::geometry::Lattice;
use nextview::map::{Integration, LogOdds, OccupancyMap, SensorModel};
use nextview_recording::{ReadOptions, Recording};

fn map(recording: &Recording) -> Vec<(IVec3, LogOdds)> {
    let mut map = OccupancyMap::new(Lattice::new(0.02).unwrap(), SensorModel::default()).unwrap();
    for frame in &recording.frames {
        map.integrate(&frame.load().unwrap(), &Integration::default()).unwrap();
    }
    map.voxels()
}

#[test]
fn all_forms_give_the_same_map() {
    let synthetic = SyntheticRecording::new(6);
    let [ours, tum, bag] = ["folder", "tum", "mcap"].map(|form| Folder::new(&format!("maps-{form}")));
    synthetic.write_folder(&ours);
    synthetic.write_tum(&tum);
    let ours = ours.open().unwrap();
    assert_eq!((ours.frames.len(), ours.skipped.len(), ours.intrinsics), (6, 0, synthetic.camera));
    for (frame, pose) in ours.frames.iter().zip(&synthetic.poses) {
        assert!(frame.world_from_camera.translation() == pose.translation());
        assert!(frame.world_from_camera.rotation().dot(pose.rotation()).abs() > 1.0 - 1e-12);
    }
    let expected = map(&ours);
    assert!(expected.len() > 10_000);
    let tum = tum.open().unwrap();
    assert_eq!(
        (tum.frames[2].name.as_str(), tum.frames[2].timestamp_s),
        ("depth/1305031102.2000.png", Some(1305031102.2))
    );
    assert_eq!(map(&tum), expected);
    for form in Form::ALL {
        bag.write("bag.mcap", bytes(&synthetic, form));
        let recording = Recording::open(&bag.0.join("bag.mcap"), &ReadOptions::default()).unwrap();
        assert_eq!(recording.frames[2].name, "message 3 of /camera/depth/image_rect_raw");
        assert_eq!(map(&recording), expected, "{form:?}");
    }
}
