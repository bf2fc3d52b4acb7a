//! Markers of the box, the next view and the frames taken.

use crate::messages::{ColorRgba, Header, Marker, MarkerArray, Point, Pose, Quaternion, Vector3};
use glam::{DQuat, DVec3};
use nextview::geometry::{self, Aabb};

/// Kinds of `visualization_msgs/msg/Marker`.
const ARROW: i32 = 0;
const CUBE: i32 = 1;
const SPHERE_LIST: i32 = 7;

/// Actions of a marker: shown, or removed.
const ADD: i32 = 0;
const DELETE: i32 = 2;

pub fn message(
    bounds: Option<Aabb>,
    next: Option<&geometry::Pose>,
    taken: &[DVec3],
    frame: &str,
) -> MarkerArray {
    let marker = |id: i32, kind: i32, is_there: bool, color: [f32; 4]| Marker {
        header: Header::of(frame),
        ns: "nextview".to_owned(),
        id,
        kind,
        action: if is_there { ADD } else { DELETE },
        color: ColorRgba { r: color[0], g: color[1], b: color[2], a: color[3] },
        ..Marker::default()
    };
    let mut around = marker(0, CUBE, bounds.is_some(), [0.3, 0.6, 1.0, 0.15]);
    if let Some(bounds) = bounds {
        around.pose = Pose { position: bounds.center().into(), orientation: Quaternion::default() };
        around.scale = bounds.size().into();
    }
    let mut arrow = marker(1, ARROW, next.is_some(), [1.0, 0.5, 0.0, 1.0]);
    if let Some(next) = next {
        // An arrow points along x, a camera looks along z.
        let axis = next.rotation() * DQuat::from_rotation_arc(DVec3::X, DVec3::Z);
        let [x, y, z, w] = axis.to_array();
        arrow.pose = Pose { position: next.translation().into(), orientation: Quaternion { x, y, z, w } };
        arrow.scale = Vector3 { x: 0.1, y: 0.015, z: 0.015 };
    }
    let mut frames = marker(2, SPHERE_LIST, !taken.is_empty(), [0.2, 0.8, 0.2, 1.0]);
    frames.points = taken.iter().map(|place| Point::from(*place)).collect();
    frames.scale = Vector3 { x: 0.02, y: 0.02, z: 0.02 };
    MarkerArray { markers: vec![around, arrow, frames] }
}
