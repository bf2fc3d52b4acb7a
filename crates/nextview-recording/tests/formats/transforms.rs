//! MCAP files whose poses are transforms, and whose images are compressed.

use crate::mcap::{
    CAMERA, COLOR, COMPRESSED_DEPTH, Cdr, Form, POSES, TF, TF_STATIC, assert_parts, file, messages, open,
};
use crate::synthetic::{Folder, SyntheticRecording, png};
use glam::{DQuat, DVec3};
use nextview::geometry::Pose;
use nextview_recording::{ReadOptions, Recording};

type Messages = Vec<(u16, Vec<u8>)>;

fn transforms(of: &[(f64, &str, &str, Pose)]) -> Vec<u8> {
    let mut cdr = Cdr::bare();
    cdr.u32(of.len() as u32);
    for (time, parent, child, pose) in of {
        cdr.header(*time, parent).text(child);
        cdr.f64s(&pose.translation().to_array()).f64s(&pose.rotation().to_array());
    }
    cdr.message()
}

fn time(i: usize) -> f64 {
    1_700_000_000.0 + 0.1 * i as f64
}

fn base() -> Pose {
    Pose::new(DQuat::from_rotation_z(0.4), DVec3::new(0.5, -1.0, 0.2)).unwrap()
}

fn lens() -> Pose {
    Pose::new(DQuat::from_rotation_x(1.1), DVec3::new(0.0, 0.03, 0.1)).unwrap()
}

/// The recording with an arm that moves through each pose at the time of the image, half way between two
/// transforms.
fn with_transforms(synthetic: &SyntheticRecording) -> Messages {
    let mut all = messages(synthetic, Form::PLAIN);
    all.retain(|(topic, _)| *topic != POSES);
    all.push((TF_STATIC, transforms(&[(0.0, "map", "base", base()), (0.0, "flange", "camera", lens())])));
    for (i, pose) in synthetic.poses.iter().enumerate() {
        let base_from_flange = base().inverse() * *pose * lens().inverse();
        for (apart, shift) in [(0.03, 0.01), (-0.03, -0.01)] {
            let shifted = base_from_flange.translation() + shift * DVec3::ONE;
            let moved = Pose::new(base_from_flange.rotation(), shifted).unwrap();
            // The last ones come first: transforms may come in any order.
            all.insert(0, (TF, transforms(&[(time(i) + apart, "base", "flange", moved)])));
        }
    }
    all
}

fn error(folder: &str, options: &ReadOptions, change: impl Fn(&mut Messages)) -> String {
    let mut messages = with_transforms(&SyntheticRecording::new(3));
    change(&mut messages);
    let folder = Folder::new(&format!("transforms-{folder}"));
    open(&folder, &file(Form::PLAIN, &messages), options).unwrap_err()
}

fn in_frame(world: &str) -> ReadOptions {
    ReadOptions { world_frame: Some(world.to_owned()), ..ReadOptions::default() }
}

#[track_caller]
fn assert_poses(recording: &Recording, expected: impl Iterator<Item = Pose>) {
    for (frame, pose) in recording.frames.iter().zip(expected) {
        let found = frame.world_from_camera;
        assert!(found.translation().distance(pose.translation()) < 1e-6, "{}", frame.name);
        assert!(found.rotation().dot(pose.rotation()).abs() > 1.0 - 1e-9, "{}", frame.name);
    }
}

#[test]
fn poses_are_found_through_the_arm_at_the_time_of_the_image() {
    let synthetic = SyntheticRecording::new(4);
    let folder = Folder::new("transforms-arm");
    let bytes = file(Form::ALL[2], &with_transforms(&synthetic));
    let recording = open(&folder, &bytes, &ReadOptions::default()).unwrap();
    assert_eq!((recording.frames.len(), recording.skipped.len(), recording.notes.len()), (4, 0, 0));
    assert_poses(&recording, synthetic.poses.iter().copied());
    let recording = open(&folder, &bytes, &in_frame("base")).unwrap();
    assert_poses(&recording, synthetic.poses.iter().map(|pose| base().inverse() * *pose));
}

#[test]
fn a_topic_of_poses_goes_first_unless_a_frame_is_named() {
    let synthetic = SyntheticRecording::new(3);
    let mut all = with_transforms(&synthetic);
    all.extend(messages(&synthetic, Form::PLAIN).into_iter().filter(|(topic, _)| *topic == POSES));
    let folder = Folder::new("transforms-both");
    let bytes = file(Form::PLAIN, &all);
    let recording = open(&folder, &bytes, &ReadOptions::default()).unwrap();
    assert_eq!(recording.frames[1].world_from_camera, synthetic.poses[1]);
    let recording = open(&folder, &bytes, &in_frame("base")).unwrap();
    assert_poses(&recording, synthetic.poses.iter().map(|pose| base().inverse() * *pose));
    let both = ReadOptions { pose_topic: Some("/camera_pose".into()), ..in_frame("map") };
    assert_parts(
        &open(&folder, &bytes, &both).unwrap_err(),
        &["from the topic /camera_pose or from transforms", "leave out the frame map as `world_frame`"],
    );
}

#[test]
fn what_is_missing_between_the_frames_is_named() {
    let default = ReadOptions::default();
    let without_static = error("no-static", &default, |all| all.retain(|(topic, _)| *topic != TF_STATIC));
    assert_parts(
        &without_static,
        &["the pose of 'camera', the frame of the images: no transform names", "one of base, flange"],
    );
    let elsewhere = error("elsewhere", &in_frame("odom"), |all| {
        all.push((TF, transforms(&[(time(0), "odom", "rover", base())])));
    });
    assert_parts(
        &elsewhere,
        &["nothing connects 'camera', a frame of the tree of 'map', to 'odom'", "`world_frame`"],
    );
    let none =
        error("none", &in_frame("map"), |all| all.retain(|(topic, _)| ![TF, TF_STATIC].contains(topic)));
    assert_parts(&none, &["no transforms, expected /tf and /tf_static with the frame map as `world_frame`"]);
}

#[test]
fn images_outside_the_times_of_the_transforms_are_left_out_and_wrong_transforms_noted() {
    let synthetic = SyntheticRecording::new(4);
    let mut all = with_transforms(&synthetic);
    // The two transforms around the last image came first.
    all.drain(..2);
    let zero = Cdr::bare().u32(1).header(time(1), "base").text("gripper").f64s(&[0.0; 7]).message();
    all.push((TF, zero.clone()));
    all.push((TF, zero));
    all.push((TF, transforms(&[(time(1), "elsewhere", "flange", base())])));
    let folder = Folder::new("transforms-hole");
    let recording = open(&folder, &file(Form::PLAIN, &all), &ReadOptions::default()).unwrap();
    assert_eq!((recording.frames.len(), recording.skipped.len()), (3, 1));
    let told = recording.skipped[0].to_string();
    assert_parts(
        &told,
        &["message 4 of ", "'flange' in 'base' is known only until", "before the requested time"],
    );
    assert_parts(
        &recording.notes.join("\n"),
        &[
            "1 transforms of 'flange' are left out",
            "do two programs",
            "2 transforms of 'gripper'",
            "quaternion is 0",
        ],
    );
}

fn compressed(topic: u16, time: f64, format: &str, data: &[u8]) -> (u16, Vec<u8>) {
    (topic, Cdr::new(false, time).text(format).blob(data).message())
}

#[test]
fn compressed_images_are_read_and_colours_where_they_are_wanted() {
    let synthetic = SyntheticRecording::new(3);
    let mut all = with_transforms(&synthetic);
    let plain_folder = Folder::new("transforms-plain");
    let plain = open(&plain_folder, &file(Form::PLAIN, &all), &ReadOptions::default()).unwrap();
    all.retain(|(topic, _)| [TF, TF_STATIC, CAMERA].contains(topic));
    let pixels: Vec<u8> = (0..80 * 60 * 3).map(|i| i as u8).collect();
    let color = png(80, 60, ::png::ColorType::Rgb, ::png::BitDepth::Eight, &pixels);
    for i in 0..3 {
        let depth = [&[0; 12], &synthetic.png(i)[..]].concat();
        all.push(compressed(COMPRESSED_DEPTH, time(i), "16UC1; compressedDepth png", &depth));
        all.push(compressed(COLOR, time(i) + 0.01, "rgb8; png compressed bgr8", &color));
    }
    let folder = Folder::new("transforms-compressed");
    let bytes = file(Form::PLAIN, &all);
    let recording = open(&folder, &bytes, &ReadOptions::default()).unwrap();
    for (frame, plain) in recording.frames.iter().zip(&plain.frames) {
        let [image, expected] = [frame, plain].map(|frame| format!("{:?}", frame.load().unwrap().image()));
        assert!(image == expected && !frame.has_color());
    }
    let options = |topic: &str| ReadOptions { color_topic: Some(topic.to_owned()), ..ReadOptions::default() };
    let recording = open(&folder, &bytes, &options("/camera/depth/color/compressed")).unwrap();
    let color = recording.frames[2].load_color().unwrap().unwrap();
    assert_eq!((recording.frames.len(), color.get(1, 0)), (3, [3, 4, 5]));
    let error = open(&folder, &bytes, &options("/rgb")).unwrap_err();
    assert_parts(
        &error,
        &["there are the colour image topics /camera/depth/color", "but no /rgb as `color_topic`"],
    );
}
