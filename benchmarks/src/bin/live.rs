//! Repeats scans with a custom camera, for `python/benchmarks/overhead.py`, which does the same in Python and
//! compares.
//!
//!     cargo run --release -p nextview-benchmarks --bin live -- PLANNER VIEWS
//!
//! For every input line, it scans once and prints a line: for each view, the milliseconds of `next` and of
//! `observe`.

use nextview::Cancel;
use nextview_scan::{Fault, LiveConfig, LiveFrame, LiveScan, ScanConfig, SimulatedObject, SourceConfig};
use nextview_sim::evaluator;
use nextview_sim::scene::CAMERA_RANGE;
use std::error::Error;
use std::time::Instant;

fn main() -> Result<(), Box<dyn Error>> {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let [planner, views] = &args[..] else { return Err("usage: live PLANNER VIEWS".into()) };
    let text =
        format!("object = 'builtin:mug'\nplanner = '{planner}'\nviews = {views}\nvoxel_size_m = 0.005");
    let config = ScanConfig::parse(&text, None, None)?;
    let object = SimulatedObject::new(&config)?;
    let bounds = object.scene.planning_box(object.voxel_size);
    let corners = [bounds.min.to_array(), bounds.max.to_array()].concat();
    let live = LiveConfig {
        box_m: Some(std::array::from_fn(|i| corners[i])),
        max_depth_m: CAMERA_RANGE,
        ..LiveConfig::default()
    };
    let source = SourceConfig::Live(live);
    let config = ScanConfig { object: "mug".to_owned(), source, ..config };
    for _ in std::io::stdin().lines() {
        println!("{}", times(&config, &object)?.join(" "));
    }
    Ok(())
}

/// The milliseconds of every call in a scan, as text.
fn times(config: &ScanConfig, object: &SimulatedObject) -> Result<Vec<String>, Box<dyn Error>> {
    let mut scan = LiveScan::begin(config.clone(), None, Cancel::default())?;
    let mut times = Vec::new();
    loop {
        let start = Instant::now();
        let next = scan.next()?.map(|next| scan.trajectory_to(&next).map(|_| next)).transpose()?;
        let next_ms = 1e3 * start.elapsed().as_secs_f64();
        let Some(next) = next else { return Ok(times) };
        let pose = next.world_from_camera;
        let (frame, _) = evaluator::capture(&object.scene, &pose, false).map_err(Fault::from)?;
        let image = frame.image().clone();
        let start = Instant::now();
        scan.observe(LiveFrame::new(image, pose))?;
        times.push(format!("{next_ms} {}", 1e3 * start.elapsed().as_secs_f64()));
    }
}
