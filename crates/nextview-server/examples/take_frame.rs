//! Stands in for a robot with a depth camera in front of a mug: reads the answer of `/next` from a file, and
//! writes the frame that the camera would take there, as the parts of a request.
//!
//! `take_frame next.json frame.json depth.png`

use nextview::sensor::Depth;
use nextview_scan::{ScanConfig, SimulatedObject, pose_of_rows};
use nextview_sim::evaluator;
use serde_json::{Value, json};
use std::error::Error;
use std::fs::{self, File};

fn main() -> Result<(), Box<dyn Error>> {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let [next, frame, depth] = &args[..] else { return Err("usage: take_frame NEXT FRAME DEPTH".into()) };
    let next: Value = serde_json::from_slice(&fs::read(next)?)?;
    let rows = &next["view"]["world_from_camera"];
    let pose = pose_of_rows("world_from_camera", &serde_json::from_value(rows.clone())?)?;

    let config = ScanConfig { object: "builtin:mug".to_owned(), baselines: false, ..ScanConfig::default() };
    let object = SimulatedObject::new(&config)?;
    let (taken, _) = evaluator::capture(&object.scene, &pose, true)?;
    let image = taken.image();

    let head = json!({ "id": format!("view-{}", next["view"]["view"]), "world_from_camera": rows });
    fs::write(frame, head.to_string())?;
    // 16-bit millimetres; 0 where nothing was measured.
    let pixels = (0..image.height()).flat_map(|v| (0..image.width()).map(move |u| image.get(u, v)));
    let millimetres = pixels.map(|pixel| match pixel {
        Depth::Surface(metres) => (1e3 * metres).round() as u16,
        Depth::Missing | Depth::Beyond => 0,
    });
    let mut encoder = png::Encoder::new(File::create(depth)?, image.width(), image.height());
    encoder.set_color(png::ColorType::Grayscale);
    encoder.set_depth(png::BitDepth::Sixteen);
    encoder.write_header()?.write_image_data(&millimetres.flat_map(u16::to_be_bytes).collect::<Vec<_>>())?;
    Ok(())
}
