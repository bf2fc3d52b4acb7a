//! Wrong inputs are named, and right ones are not suspected.

#![allow(clippy::unwrap_used, reason = "helpers of tests")]

use glam::{DMat3, DQuat, DVec2, DVec3};
use nextview::diagnosis::{Reading, Suspicion, suspect, suspect_poses};
use nextview::geometry::{Aabb, Pose};
use nextview::sensor::{CameraAxes, Depth, DepthImage, DepthRange, Frame, Intrinsics};
use nextview::view::look_at;

const WIDTH: u32 = 160;
const HEIGHT: u32 = 120;

fn optics() -> Intrinsics {
    let center = DVec2::new(79.5, 59.5);
    Intrinsics::pinhole(WIDTH, HEIGHT, DVec2::splat(150.0), center).unwrap()
}

/// The object: a ball of 10 cm at a place away from the origin.
fn ball() -> (DVec3, f64) {
    (DVec3::new(0.3, -0.2, 0.15), 0.05)
}

fn bounds() -> Aabb {
    Aabb::cube(ball().0, 0.07)
}

/// The depth of the ball and, if there is one, of the table below it, from a pose.
fn image(world_from_camera: &Pose, has_table: bool) -> DepthImage {
    let (center, radius) = ball();
    let camera = world_from_camera.translation() - center;
    let depth = |i: u32| {
        let pixel = DVec2::new((i % WIDTH) as f64, (i / WIDTH) as f64);
        let ray = world_from_camera.rotation() * optics().deproject(pixel).unwrap().extend(1.0);
        let (a, b, c) = (ray.length_squared(), camera.dot(ray), camera.length_squared() - radius * radius);
        let root = b * b - a * c;
        let on_ball = if root > 0.0 { (-b - root.sqrt()) / a } else { f64::NAN };
        let to_table = (-radius - camera.z) / ray.z;
        let on_table = if has_table && to_table > 0.0 { to_table } else { f64::NAN };
        on_ball.min(on_table) as f32
    };
    DepthImage::from_metres(WIDTH, HEIGHT, (0..WIDTH * HEIGHT).map(depth).collect()).unwrap()
}

/// What a camera that goes around the ball shows.
fn frames(has_table: bool) -> Vec<Frame> {
    let around = |i: usize| {
        let angle = i as f64 * 0.9;
        let offset = DVec3::new(angle.cos(), angle.sin(), 0.5 + 0.1 * i as f64);
        let pose = look_at(ball().0 + offset * 0.35, ball().0).unwrap();
        Frame::new(image(&pose, has_table), optics(), pose, 10.0).unwrap()
    };
    (0..5).map(around).collect()
}

fn with_poses(frames: &[Frame], wrong: impl Fn(&Pose) -> Pose) -> Vec<Frame> {
    frames.iter().map(|frame| frame.clone().with_pose(wrong(&frame.world_from_camera()))).collect()
}

fn with_depths(frames: &[Frame], factor: f32) -> Vec<Frame> {
    let wrong = |frame: &Frame| {
        let depth = |i: u32| match frame.image().get(i % WIDTH, i / WIDTH) {
            Depth::Surface(depth) => depth * factor,
            _ => f32::NAN,
        };
        let depth = (0..WIDTH * HEIGHT).map(depth).collect();
        let image = DepthImage::from_metres(WIDTH, HEIGHT, depth).unwrap();
        Frame::new(image, *frame.intrinsics(), frame.world_from_camera(), 10.0).unwrap()
    };
    frames.iter().map(wrong).collect()
}

fn turned(pose: &Pose, basis: DMat3) -> Pose {
    Pose::new(pose.rotation() * DQuat::from_mat3(&basis), pose.translation()).unwrap()
}

fn moved(pose: &Pose, factor: f64) -> Pose {
    Pose::new(pose.rotation(), pose.translation() * factor).unwrap()
}

/// Ways to get poses and units wrong, and how they are to be read.
fn wrong_inputs(right: &[Frame]) -> Vec<(Vec<Frame>, Reading)> {
    let to_opengl = DMat3::from_diagonal(DVec3::new(1.0, -1.0, -1.0));
    let to_ros = DMat3::from_cols(DVec3::Z, -DVec3::X, -DVec3::Y);
    let w_first = |pose: &Pose| {
        let [x, y, z, w] = pose.rotation().to_array();
        Pose::new(DQuat::from_xyzw(w, x, y, z), pose.translation()).unwrap()
    };
    vec![
        (with_poses(right, |pose| turned(pose, to_opengl)), Reading::Axes(CameraAxes::OpenGl)),
        (with_poses(right, |pose| turned(pose, to_ros)), Reading::Axes(CameraAxes::Ros)),
        (with_poses(right, |pose| CameraAxes::Ros.to_opencv(pose)), Reading::TurnedFromRos),
        (with_poses(right, Pose::inverse), Reading::Inverted),
        (with_poses(right, w_first), Reading::WFirst),
        (with_poses(right, |pose| moved(pose, 1e3)), Reading::Positions(0.001)),
        (with_poses(right, |pose| moved(pose, 1e2)), Reading::Positions(0.01)),
        (with_poses(right, |pose| moved(pose, 1e-3)), Reading::Positions(1000.0)),
        (with_depths(right, 1e3), Reading::Depths(0.001)),
        (with_depths(right, 1e-3), Reading::Depths(1000.0)),
        (with_depths(right, 10.0), Reading::Depths(0.1)),
        (with_depths(right, 0.1), Reading::Depths(10.0)),
        (with_depths(right, 5.0), Reading::Depths(0.2)),
        (with_depths(right, 0.2), Reading::Depths(5.0)),
    ]
}

#[test]
fn wrong_readings_are_named() {
    for has_table in [false, true] {
        for bounds in [None, Some(bounds())] {
            for (frames, reading) in wrong_inputs(&frames(has_table)) {
                let found = suspect(&frames, bounds, DepthRange::default());
                let is_it = found == Some(Suspicion::Misread(reading));
                assert!(is_it, "{found:?} instead of {reading:?} (table: {has_table}, box: {bounds:?})");
            }
        }
    }
}

/// A frame alone may show the box under several readings.
#[test]
fn a_reading_is_named_only_if_no_other_fits_as_well() {
    let of = |n: usize| {
        let nearer = with_depths(&frames(false)[..n], 0.2);
        suspect(&nearer, Some(Aabb::cube(ball().0, 0.13)), DepthRange::default())
    };
    assert!(
        matches!(of(1), Some(Suspicion::Elsewhere { .. })),
        "4 and 5 times as deep is in the box: {:?}",
        of(1)
    );
    assert_eq!(of(2), Some(Suspicion::Misread(Reading::Depths(5.0))));
}

#[test]
fn right_frames_are_not_suspected() {
    for has_table in [false, true] {
        for bounds in [None, Some(bounds())] {
            for n in 1..=5 {
                let found = suspect(&frames(has_table)[..n], bounds, DepthRange::default());
                assert_eq!(found, None, "{n} frames (table: {has_table}, box: {bounds:?})");
            }
        }
    }
    assert_eq!(suspect(&[], Some(bounds()), DepthRange::default()), None);
}

#[test]
fn a_camera_that_is_too_near_or_too_far_is_named() {
    let blind = |distance: f64| {
        let pose = look_at(ball().0 + DVec3::X * distance, ball().0).unwrap();
        let nothing =
            DepthImage::from_metres(WIDTH, HEIGHT, vec![f32::NAN; (WIDTH * HEIGHT) as usize]).unwrap();
        vec![Frame::new(nothing, optics(), pose, 10.0).unwrap()]
    };
    let range = DepthRange { min: 0.17, max: 1.0 };
    let text = |distance| suspect(&blind(distance), Some(bounds()), range).unwrap().to_string();
    assert!(text(0.12).contains("too near: 0.050 m"), "{}", text(0.12));
    assert!(text(2.0).contains("too far away: 1.930 m"), "{}", text(2.0));
    assert!(text(0.4).contains("only 0.0 % of the pixels"), "{}", text(0.4));
}

#[test]
fn a_box_elsewhere_and_poses_that_do_not_move_are_named() {
    let elsewhere = Aabb::cube(DVec3::splat(2.0), 0.1);
    let found = suspect(&frames(false), Some(elsewhere), DepthRange::default()).unwrap();
    assert!(matches!(found, Suspicion::Elsewhere { bounds, .. } if bounds == elsewhere), "{found}");
    let right = frames(true);
    let still = with_poses(&right, |_| right[0].world_from_camera());
    assert_eq!(suspect(&still, None, DepthRange::default()), Some(Suspicion::SamePose));
    assert_eq!(
        suspect(&vec![right[0].clone(); 4], None, DepthRange::default()),
        None,
        "one view, four times"
    );
}

/// A scan whose first frame sees the object, while no other pose does, ends there: no frames to compare.
#[test]
fn poses_that_look_elsewhere_are_named_after_one_frame() {
    let suspicion = |frames: &[Frame]| {
        let poses: Vec<Pose> = frames.iter().map(Frame::world_from_camera).collect();
        suspect_poses(&frames[0], &poses)
    };
    let right = frames(true);
    assert_eq!(suspicion(&right), None);
    for (wrong, reading) in wrong_inputs(&right) {
        let found = suspicion(&wrong);
        let must = matches!(reading, Reading::Axes(CameraAxes::OpenGl) | Reading::Inverted);
        let is_named = found == Some(Suspicion::Misread(reading));
        assert!(is_named || found.is_none() && !must, "{reading}: {found:?}");
    }
    let still = |n| with_poses(&right[..n], |_| right[0].world_from_camera());
    assert_eq!(suspicion(&still(4)), Some(Suspicion::SamePose));
    assert_eq!(suspicion(&still(3)), None, "too few to tell");
}
