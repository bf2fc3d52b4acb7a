//! A data set of the BOP benchmark (Hodaň et al. 2018): the object as number 1, the views as scene 1 of
//! `train`, lengths in millimetres.

use super::out::Out;
use crate::masks::{Mask, Masks};
use crate::scanned::Scanned;
use crate::view::UndistortedView;
use glam::DVec3;
use nextview::geometry::sphere;
use nextview::sensor::Depth;
use nextview::surface::CloudPoint;
use nextview_model::write_mesh;
use nextview_recording::{encode_color, encode_depth, encode_mask};
use nextview_scan::{Fault, rows_of_pose};
use serde_json::{Map, Value, json};

/// Metres per unit of depth.
const UNIT: f64 = 0.0001;

/// Millimetres per metre.
const MM: f64 = 1e3;

const SCENE: &str = "train/000001";

pub(super) fn write(scanned: &Scanned, out: &mut Out) -> Result<(), Fault> {
    let (width, height) = (scanned.intrinsics.width(), scanned.intrinsics.height());
    let (focal, center) = (scanned.intrinsics.focal(), scanned.intrinsics.center());
    let camera = json!({
        "cx": center.x, "cy": center.y, "fx": focal.x, "fy": focal.y, "width": width, "height": height,
        "depth_scale": MM * UNIT,
    });
    out.add_json("camera.json", &camera);
    write_model(scanned, out)?;
    let matrix = [focal.x, 0.0, center.x, 0.0, focal.y, center.y, 0.0, 0.0, 1.0];
    let masks = Masks::new(scanned)?;
    let [mut cameras, mut poses, mut infos] = [(); 3].map(|()| Map::new());
    for view in &scanned.views {
        let (stem, number) = (view.stem(), view.number.to_string());
        let mask = masks.of(view)?;
        out.add(format!("{SCENE}/depth/{stem}.png"), encode_depth(view.frame.image(), UNIT));
        if let Some(color) = &view.color {
            out.add(format!("{SCENE}/rgb/{stem}.png"), encode_color(color));
        }
        out.add(format!("{SCENE}/mask/{stem}_000000.png"), encode_mask(width, height, &mask.whole));
        out.add(format!("{SCENE}/mask_visib/{stem}_000000.png"), encode_mask(width, height, &mask.visible));
        // The model lies in the world as scanned: one pose for both.
        let (rotation, translation) = camera_from_world(view);
        cameras.insert(
            number.clone(),
            json!({ "cam_K": matrix, "depth_scale": MM * UNIT, "cam_R_w2c": rotation, "cam_t_w2c": translation }),
        );
        poses.insert(
            number.clone(),
            json!([{ "cam_R_m2c": rotation, "cam_t_m2c": translation, "obj_id": 1 }]),
        );
        infos.insert(number, json!([info(view, &mask, width)]));
    }
    out.add_json(&format!("{SCENE}/scene_camera.json"), &Value::Object(cameras));
    out.add_json(&format!("{SCENE}/scene_gt.json"), &Value::Object(poses));
    out.add_json(&format!("{SCENE}/scene_gt_info.json"), &Value::Object(infos));
    Ok(())
}

/// Rotation row by row, and translation in millimetres.
fn camera_from_world(view: &UndistortedView) -> (Vec<f64>, Vec<f64>) {
    let rows = rows_of_pose(&view.world_from_camera().inverse());
    let rotation = rows[..3].iter().flat_map(|row| row[..3].to_vec()).collect();
    (rotation, rows[..3].iter().map(|row| MM * row[3]).collect())
}

fn write_model(scanned: &Scanned, out: &mut Out) -> Result<(), Fault> {
    let in_mm = |point: &CloudPoint| CloudPoint { position: MM * point.position, ..*point };
    let points: Vec<CloudPoint> = scanned.object.points.iter().map(in_mm).collect();
    let mut bytes = Vec::new();
    write_mesh(&mut bytes, &points, None, &scanned.object.triangles)?;
    out.add("models/obj_000001.ply", bytes);
    let positions: Vec<DVec3> = points.iter().map(|point| point.position).collect();
    let low = positions.iter().copied().fold(DVec3::INFINITY, DVec3::min);
    let size = positions.iter().copied().fold(DVec3::NEG_INFINITY, DVec3::max) - low;
    let info = json!({
        "diameter": diameter(&positions),
        "min_x": low.x, "min_y": low.y, "min_z": low.z,
        "size_x": size.x, "size_y": size.y, "size_z": size.z,
    });
    out.add_json("models/models_info.json", &json!({ "1": info }));
    Ok(())
}

/// Number of directions in which an end of the diameter is searched: 1.4 degrees apart, which misses less
/// than a thousandth.
const DIRECTIONS: usize = 4096;

/// The largest distance between two points. Its ends are outermost in some direction, so only distances from
/// the points that are outermost in one of the directions are computed.
fn diameter(points: &[DVec3]) -> f64 {
    let outermost = |direction: DVec3| {
        points.iter().copied().max_by(|a, b| a.dot(direction).total_cmp(&b.dot(direction)))
    };
    let mut ends: Vec<DVec3> =
        (0..DIRECTIONS).filter_map(|i| outermost(sphere::fibonacci(i, DIRECTIONS))).collect();
    ends.dedup();
    let farthest = |end: &DVec3| points.iter().map(|point| point.distance_squared(*end)).fold(0.0, f64::max);
    ends.iter().map(farthest).fold(0.0, f64::max).sqrt()
}

fn info(view: &UndistortedView, mask: &Mask, width: u32) -> Value {
    let count = |mask: &[bool]| mask.iter().filter(|is_object| **is_object).count();
    let (n_all, n_visible) = (count(&mask.whole), count(&mask.visible));
    let is_valid = |(pixel, is_object): (Depth, &bool)| *is_object && matches!(pixel, Depth::Surface(_));
    let n_valid = view.frame.image().pixels().zip(&mask.whole).filter(|pair| is_valid(*pair)).count();
    json!({
        "bbox_obj": bounds(&mask.whole, width),
        "bbox_visib": bounds(&mask.visible, width),
        "px_count_all": n_all,
        "px_count_valid": n_valid,
        "px_count_visib": n_visible,
        "visib_fract": if n_all > 0 { n_visible as f64 / n_all as f64 } else { 0.0 },
    })
}

/// Left, top, width and height of the box around the true pixels; -1 if there are none, as in the benchmark.
fn bounds(mask: &[bool], width: u32) -> [i64; 4] {
    let places = mask.iter().enumerate().filter(|(_, is_object)| **is_object);
    let places = places.map(|(i, _)| [(i % width as usize) as i64, (i / width as usize) as i64]);
    let grown = places.fold(None, |bounds: Option<[[i64; 2]; 2]>, p| {
        let [low, high] = bounds.unwrap_or([p, p]);
        Some([[low[0].min(p[0]), low[1].min(p[1])], [high[0].max(p[0]), high[1].max(p[1])]])
    });
    grown.map_or([-1; 4], |[low, high]| [low[0], low[1], high[0] - low[0] + 1, high[1] - low[1] + 1])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_diameter_is_the_largest_distance() {
        // A curve without symmetry.
        let point = |i: usize| {
            let t = i as f64 / 50.0;
            DVec3::new(t.sin() * t, (1.3 * t).cos(), 0.2 * t * t)
        };
        let points: Vec<DVec3> = (0..400).map(point).collect();
        let pairs = points.iter().flat_map(|a| points.iter().map(|b| a.distance(*b)));
        let expected = pairs.fold(0.0, f64::max);
        assert!((diameter(&points) - expected).abs() < 1e-3 * expected);
    }

    #[test]
    fn boxes_hold_their_pixels() {
        let mut mask = vec![false; 5 * 4];
        assert_eq!(bounds(&mask, 5), [-1; 4]);
        (mask[5 + 1], mask[2 * 5 + 3]) = (true, true);
        assert_eq!(bounds(&mask, 5), [1, 1, 3, 2]);
    }
}
