//! Files of another writer: the Python package `rosbags`, which knows ROS 2's messages by itself.

use crate::synthetic::{Folder, SyntheticRecording};
use nextview_checks::skipped;
use nextview_recording::{ReadOptions, Recording};
use std::process::Command;

#[test]
fn bags_of_rosbags_read_as_the_folder_they_were_made_of() {
    let Ok(python) = std::env::var("NEXTVIEW_ROSBAGS_PYTHON") else {
        let why = "NEXTVIEW_ROSBAGS_PYTHON names no Python with the packages rosbags, numpy and pillow";
        return skipped("bags_of_rosbags_read_as_the_folder_they_were_made_of", "rosbags", why);
    };
    let synthetic = SyntheticRecording::new(4);
    let folder = Folder::new("rosbags");
    synthetic.write_folder(&folder);
    let expected = folder.open().unwrap();
    for form in ["plain", "metres", "compressed", "png"] {
        let script = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/formats/write_bag.py");
        let status = Command::new(&python).arg(script).arg(&folder.0).arg(form).status().unwrap();
        assert!(status.success());
        let bag = folder.0.join(form).join(format!("{form}.mcap"));
        let recording = Recording::open(&bag, &ReadOptions::default()).unwrap();
        assert_eq!((recording.frames.len(), recording.notes.len()), (4, 0), "{form}");
        assert_eq!(recording.intrinsics, expected.intrinsics);
        for (frame, expected) in recording.frames.iter().zip(&expected.frames) {
            let (found, pose) = (frame.world_from_camera, expected.world_from_camera);
            assert!(found.translation().distance(pose.translation()) < 1e-9, "{form}");
            assert!(found.rotation().dot(pose.rotation()).abs() > 1.0 - 1e-12, "{form}");
            let [image, expected] =
                [frame, expected].map(|frame| format!("{:?}", frame.load().unwrap().image()));
            assert!(image == expected, "{form}");
        }
    }
}
