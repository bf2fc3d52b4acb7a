//! A client: scans a mug through a running server, with a simulated camera in place of a real one.
//!
//! `nextview serve` in one terminal, `cargo run -p nextview-server --example client` in another.

use nextview::sensor::{Depth, DepthImage};
use nextview_scan::{ScanConfig, SimulatedObject, pose_of_rows};
use nextview_sim::evaluator;
use serde_json::{Value, json};
use std::error::Error;

fn main() -> Result<(), Box<dyn Error>> {
    let server = std::env::args().nth(1).unwrap_or_else(|| "http://127.0.0.1:7878".to_owned());
    let config = ScanConfig { object: "builtin:mug".to_owned(), baselines: false, ..ScanConfig::default() };
    let robot = SimulatedObject::new(&config)?;
    let bounds = robot.scene.planning_box(robot.voxel_size);

    let corners = [bounds.min.to_array(), bounds.max.to_array()].concat();
    let body = json!({ "object": "mug", "views": 6, "candidates": 200, "live": { "box_m": corners } });
    let created: Value = ureq::post(format!("{server}/scans")).send_json(&body)?.body_mut().read_json()?;
    let scan = format!("{server}/scans/{}", created["id"].as_str().unwrap_or_default());
    loop {
        let next: Value = ureq::get(format!("{scan}/next")).call()?.body_mut().read_json()?;
        if next["state"] != "view" {
            println!("over: {}", next["stop_reason"]);
            break;
        }
        let rows = &next["view"]["world_from_camera"];
        let pose = pose_of_rows("world_from_camera", &serde_json::from_value(rows.clone())?)?;
        let (frame, _) = evaluator::capture(&robot.scene, &pose, false)?;
        let step: Value = ureq::post(frame_address(&scan, &next["view"], frame.image()))
            .content_type("application/octet-stream")
            .send(&little_endian(frame.image())[..])?
            .body_mut()
            .read_json()?;
        println!("view {}: {} new voxels", step["view"], step["new_voxels"]);
    }
    let finished: Value = ureq::post(format!("{scan}/finish")).send_empty()?.body_mut().read_json()?;
    println!("{} views; {scan}/files/mesh.ply", finished["record"]["views"]);
    Ok(())
}

/// The address to which a frame is posted as raw numbers. The frame's id is that of the view: sent again, it
/// counts once.
fn frame_address(scan: &str, view: &Value, image: &DepthImage) -> String {
    let rows = view["world_from_camera"].as_array().into_iter().flatten();
    let numbers: Vec<String> =
        rows.flat_map(|row| row.as_array().into_iter().flatten()).map(Value::to_string).collect();
    format!(
        "{scan}/frames?id=view-{}&width={}&height={}&dtype=f32&world_from_camera={}",
        view["view"],
        image.width(),
        image.height(),
        numbers.join(",")
    )
}

/// Metres; NaN where nothing was measured, infinity for pixels without return.
fn little_endian(image: &DepthImage) -> Vec<u8> {
    let pixels = (0..image.height()).flat_map(|v| (0..image.width()).map(move |u| image.get(u, v)));
    let metres = pixels.map(|pixel| match pixel {
        Depth::Missing => f32::NAN,
        Depth::Beyond => f32::INFINITY,
        Depth::Surface(depth) => depth,
    });
    metres.flat_map(f32::to_le_bytes).collect()
}
