//! `transforms.json` of nerfstudio, also read by instant-ngp: cameras with OpenGL axes (x right, y up, z
//! backward) in our world.

use super::out::Out;
use crate::masks::Masks;
use crate::scanned::Scanned;
use nextview::geometry::Pose;
use nextview_model::write_cloud;
use nextview_recording::{encode_color, encode_depth, encode_mask};
use nextview_scan::{Fault, rows_of_pose};
use serde_json::json;

/// Metres per unit of depth: nerfstudio's default.
const UNIT: f64 = 0.001;

/// nerfstudio's centre of the first pixel is (0.5, 0.5).
const PIXEL_CENTER: f64 = 0.5;

pub(super) fn write(scanned: &Scanned, out: &mut Out) -> Result<(), Fault> {
    let (width, height) = (scanned.intrinsics.width(), scanned.intrinsics.height());
    let (focal, center) = (scanned.intrinsics.focal(), scanned.intrinsics.center());
    let masks = Masks::new(scanned)?;
    let mut frames = Vec::new();
    for view in &scanned.views {
        let stem = view.stem();
        let [image, depth, mask] = ["images", "depths", "masks"].map(|folder| format!("{folder}/{stem}.png"));
        out.add(depth.clone(), encode_depth(view.frame.image(), UNIT));
        out.add(mask.clone(), encode_mask(width, height, &masks.of(view)?.visible));
        if let Some(color) = &view.color {
            out.add(image.clone(), encode_color(color));
        }
        frames.push(json!({
            "file_path": image,
            "depth_file_path": depth,
            "mask_path": mask,
            "transform_matrix": opengl(&view.world_from_camera()),
        }));
    }
    let mut cloud = Vec::new();
    write_cloud(&mut cloud, &scanned.cloud.points)?;
    out.add("sparse_pc.ply", cloud);
    let transforms = json!({
        "camera_model": "OPENCV",
        "w": width,
        "h": height,
        "fl_x": focal.x,
        "fl_y": focal.y,
        "cx": center.x + PIXEL_CENTER,
        "cy": center.y + PIXEL_CENTER,
        "k1": 0.0,
        "k2": 0.0,
        "p1": 0.0,
        "p2": 0.0,
        "ply_file_path": "sparse_pc.ply",
        "frames": frames,
    });
    out.add_json("transforms.json", &transforms);
    Ok(())
}

/// The rows of the camera's matrix with OpenGL axes: y and z are reversed.
fn opengl(world_from_camera: &Pose) -> [[f64; 4]; 4] {
    rows_of_pose(world_from_camera).map(|[x, y, z, t]| [x, -y, -z, t])
}
