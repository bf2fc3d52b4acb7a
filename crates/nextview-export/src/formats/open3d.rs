//! Colour and depth images with Open3D's camera trajectory, as JSON and as the `.log` of Choi et al. (2015).

use super::out::Out;
use crate::scanned::Scanned;
use crate::view::matrix_text;
use nextview_recording::{encode_color, encode_depth};
use nextview_scan::rows_of_pose;
use serde_json::{Value, json};
use std::fmt::Write;

/// Metres per unit of depth: Open3D's `depth_scale` of 1000.
const UNIT: f64 = 0.001;

pub(super) fn write(scanned: &Scanned, out: &mut Out) {
    let intrinsic = intrinsic(scanned);
    let mut log = String::new();
    let mut parameters = Vec::new();
    for (i, view) in scanned.views.iter().enumerate() {
        let pose = view.world_from_camera();
        let _ = write!(log, "{i} {i} {}\n{}", i + 1, matrix_text(&pose)); // to memory
        parameters.push(json!({
            "class_name": "PinholeCameraParameters",
            "version_major": 1,
            "version_minor": 0,
            "extrinsic": by_columns(&rows_of_pose(&pose.inverse())),
            "intrinsic": intrinsic,
        }));
        let stem = view.stem();
        out.add(format!("depth/{stem}.png"), encode_depth(view.frame.image(), UNIT));
        if let Some(color) = &view.color {
            out.add(format!("color/{stem}.png"), encode_color(color));
        }
    }
    out.add_json("intrinsic.json", &intrinsic);
    out.add("trajectory.log", log);
    let trajectory = json!({
        "class_name": "PinholeCameraTrajectory",
        "version_major": 1,
        "version_minor": 0,
        "parameters": parameters,
    });
    out.add_json("camera_trajectory.json", &trajectory);
}

fn intrinsic(scanned: &Scanned) -> Value {
    let (focal, center) = (scanned.intrinsics.focal(), scanned.intrinsics.center());
    let matrix = [[focal.x, 0.0, center.x], [0.0, focal.y, center.y], [0.0, 0.0, 1.0]];
    json!({
        "width": scanned.intrinsics.width(),
        "height": scanned.intrinsics.height(),
        "intrinsic_matrix": by_columns(&matrix),
    })
}

/// The entries of a matrix column by column, as in Open3D.
fn by_columns<const N: usize>(rows: &[[f64; N]; N]) -> Vec<f64> {
    (0..N).flat_map(|column| rows.iter().map(move |row| row[column])).collect()
}
