//! A simulated depth camera in front of a mug, for checks of the node. Without arguments, it reads one pose
//! per line: the position and the quaternion x y z w of the camera in the world. For each, it writes the
//! image: 640 x 480 little-endian 32-bit floats in metres, NaN where nothing is measured.
//!
//! `simulated_camera scan VIEWS` scans in this process. At the end, it prints the numbers of the views and
//! how many voxels are occupied and free.

use glam::{DQuat, DVec2, DVec3};
use nextview::Cancel;
use nextview::geometry::Pose;
use nextview::sensor::{Depth, DepthImage, Intrinsics};
use nextview_recording::ros::TransformTree;
use nextview_scan::{LiveConfig, LiveFrame, LiveScan, ScanConfig, SimulatedObject, SourceConfig};
use nextview_sim::evaluator;
use std::error::Error;
use std::io::{BufRead, Write};

fn main() -> Result<(), Box<dyn Error>> {
    // Without distortion, like rectified images.
    let camera = Intrinsics::pinhole(640, 480, DVec2::splat(610.0), DVec2::new(319.5, 239.5))?;
    let object = "builtin:mug".to_owned();
    let config = ScanConfig { object, camera, baselines: false, ..ScanConfig::default() };
    let object = SimulatedObject::new(&config)?;
    let image = |pose: &Pose| -> Result<Vec<f32>, Box<dyn Error>> {
        let (taken, _) = evaluator::capture(&object.scene, pose, true)?;
        let image = taken.image();
        let pixels = (0..image.height()).flat_map(|v| (0..image.width()).map(move |u| image.get(u, v)));
        Ok(pixels.map(|pixel| if let Depth::Surface(metres) = pixel { metres } else { f32::NAN }).collect())
    };
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    match &arguments[..] {
        [] => {
            for line in std::io::stdin().lock().lines() {
                let line = line?;
                let numbers: Vec<f64> = line.split_whitespace().map(str::parse).collect::<Result<_, _>>()?;
                let [x, y, z, qx, qy, qz, qw] = numbers[..] else {
                    return Err("expected seven numbers".into());
                };
                let pose = Pose::new(DQuat::from_xyzw(qx, qy, qz, qw), DVec3::new(x, y, z))?;
                let bytes: Vec<u8> = image(&pose)?.into_iter().flat_map(f32::to_le_bytes).collect();
                std::io::stdout().lock().write_all(&bytes)?;
                std::io::stdout().flush()?;
            }
        }
        [scan, views] if scan == "scan" => {
            let live =
                LiveConfig { box_m: Some([-0.08, -0.08, -0.02, 0.08, 0.08, 0.14]), ..LiveConfig::default() };
            let config = ScanConfig {
                object: "object".to_owned(),
                views: Some(views.parse()?),
                candidates: 200,
                camera,
                source: SourceConfig::Live(live),
                ..ScanConfig::default()
            };
            let mut scan = LiveScan::begin(config, None, Cancel::default())?;
            let mut views = Vec::new();
            while let Some(next) = scan.next()? {
                views.push(next.view);
                let pose = next.world_from_camera;
                // Passed through a transform, as in the node: even a last bit may change the plan.
                let mut tree = TransformTree::new(0.0);
                tree.insert("map", "optical", 0.0, Pose::new(pose.rotation(), pose.translation())?)?;
                let pose = tree.lookup("map", "optical", 0.0)?;
                let depth = DepthImage::from_metres(640, 480, image(&pose)?)?;
                scan.observe(LiveFrame::new(depth, pose))?;
            }
            let known = scan.scan().steps.last().map(|step| [step.occupied_voxels, step.free_voxels]);
            let (focal, center) = (camera.focal(), camera.center());
            let intrinsics = [focal.x, focal.y, center.x, center.y];
            println!(
                "{}",
                serde_json::json!({ "views": views, "known_voxels": known, "intrinsics": intrinsics })
            );
        }
        _ => return Err("usage: simulated_camera [scan VIEWS]".into()),
    }
    Ok(())
}
