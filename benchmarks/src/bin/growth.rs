//! Growth of a decision's time and memory with the number of candidates and the voxel size, and of a map
//! update's with the image size. Every point is a separate process with its own peak memory.
//!
//!     cargo run --release -p nextview-benchmarks --bin growth -- FOLDER [PLOT.svg]
//!
//! FOLDER holds a workload. Prints a line `SWEEP,SIZE,MILLISECONDS,MEGABYTES` per point, and for each sweep
//! the exponents of time and memory over its upper half; draws the plot on request.

use glam::DVec2;
use nextview::Cancel;
use nextview::geometry::Aabb;
use nextview::map::Integration;
use nextview::planner::{MaxFlow, MaxFlowConfig, Situation, ViewPlanner};
use nextview::sensor::Intrinsics;
use nextview::view::generate;
use nextview_benchmarks::Outcome;
use nextview_benchmarks::log_plot::{Measurement, Panel, draw, exponent};
use nextview_benchmarks::peak_memory_mb;
use nextview_benchmarks::workload::{Set, Workload, block, empty_map, intrinsics, ray_spacing_of_image_grid};
use nextview_sim::camera::{Background, SimulatedCamera};
use std::path::Path;
use std::process::Command;
use std::time::Instant;

const SWEEPS: [(&str, &str, &[f64]); 4] = [
    ("decision over candidates; 5 mm", "candidates", &[1e3, 2e3, 5e3, 1e4, 2e4, 5e4, 1e5]),
    ("decision over voxel size; 5000 candidates", "voxels per metre", VOXELS_PER_METRE),
    ("decision over voxel size; 32 x 24 rays per view", "voxels per metre", VOXELS_PER_METRE),
    ("map update over image size; 5 mm", "pixels", &[19_200.0, 76_800.0, 307_200.0, 1_228_800.0]),
];

const VOXELS_PER_METRE: &[f64] = &[50.0, 100.0, 200.0, 500.0, 1000.0];
fn main() -> Outcome<()> {
    let args: Vec<String> = std::env::args().skip(1).collect();
    match args.as_slice() {
        [folder] => sweep(folder, None),
        [folder, plot] => sweep(folder, Some(Path::new(plot))),
        [folder, sweep, size] => measure(Path::new(folder), sweep.parse()?, size.parse()?),
        _ => Err("usage: growth FOLDER [PLOT.svg]".into()),
    }
}

fn sweep(folder: &str, plot: Option<&Path>) -> Outcome<()> {
    let mut panels = Vec::new();
    for (number, (title, x_label, sizes)) in SWEEPS.iter().enumerate() {
        let mut points = Vec::new();
        for size in *sizes {
            let program = Command::new(std::env::current_exe()?)
                .args([folder, &number.to_string(), &size.to_string()])
                .output()?;
            let text = String::from_utf8(program.stdout)?;
            let numbers: Vec<f64> = text.split_whitespace().filter_map(|word| word.parse().ok()).collect();
            let &[ms, mb] = numbers.as_slice() else {
                return Err(format!("{title}, {size}: {}", String::from_utf8_lossy(&program.stderr)).into());
            };
            println!("{title},{size},{ms:.3},{mb:.0}");
            points.push(Measurement { size: *size, ms, mb });
        }
        let panel = Panel { title: (*title).to_owned(), x_label: (*x_label).to_owned(), points };
        println!(
            "{title}: time grows with the power {:.2}, memory {:.2}",
            exponent(&panel.points, |point| point.ms),
            exponent(&panel.points, |point| point.mb)
        );
        panels.push(panel);
    }
    plot.map_or(Ok(()), |plot| Ok(std::fs::write(plot, draw(&panels))?))
}

/// Prints milliseconds, the median of several runs, and the process's peak memory in megabytes.
fn measure(folder: &Path, sweep: usize, size: f64) -> Outcome<()> {
    let workload = Workload::read(folder)?;
    let before = peak_memory_mb()?;
    let ms = match sweep {
        0 => decision_ms(&workload, 0.005, size as usize, MaxFlowConfig::default())?,
        1 => decision_ms(&workload, 1.0 / size, 5000, MaxFlowConfig::default())?,
        2 => {
            let ray_spacing = ray_spacing_of_image_grid(1.0 / size);
            decision_ms(&workload, 1.0 / size, 5000, MaxFlowConfig { ray_spacing, ..Default::default() })?
        }
        _ => update_ms(workload, size)?,
    };
    println!("{ms} {}", peak_memory_mb()? - before);
    Ok(())
}

/// A decision after three images, with carving.
fn decision_ms(
    workload: &Workload,
    voxel_size: f64,
    n_candidates: usize,
    config: MaxFlowConfig,
) -> Outcome<f64> {
    let snapshot = workload.snapshot(Set::B, voxel_size, 3);
    let views = generate::fibonacci_sphere(glam::DVec3::ZERO, 0.5, n_candidates)?;
    let planner = MaxFlow::new(config)?;
    let (optics, cancel) = (intrinsics(), Cancel::default());
    let situation = Situation::new(&snapshot, &views, &optics, &cancel);
    // A planner that remembers its plans would do different work each time.
    Ok(median_ms(|| _ = planner.clone().plan(&situation)))
}

/// Inserts a frame with this number of pixels, 4 : 3, into an empty map.
fn update_ms(workload: Workload, n_pixels: f64) -> Outcome<f64> {
    let scale = (n_pixels / (640.0 * 480.0)).sqrt();
    let [width, height] = [640.0, 480.0].map(|pixels| (pixels * scale).round());
    let center = DVec2::new(0.5 * width, 0.5 * height);
    let optics = Intrinsics::pinhole(width as u32, height as u32, DVec2::splat(610.0 * scale), center)?;
    let room = Background::Room(Aabb::cube(glam::DVec3::ZERO, 0.6));
    let camera = SimulatedCamera::new(workload.meshes[0].clone(), optics, room, 10.0)?;
    let frame = camera.capture(&workload.poses[0])?;
    let integration = Integration { region: Some(block(0.005)), ..Default::default() };
    Ok(median_ms(|| _ = empty_map(0.005).integrate(&frame, &integration)))
}

/// The median of at most nine runs; of fewer if they take more than three seconds in total.
fn median_ms(mut work: impl FnMut()) -> f64 {
    let mut times = Vec::new();
    while times.len() < 9 && times.iter().sum::<f64>() < 3e3 {
        let start = Instant::now();
        work();
        times.push(1e3 * start.elapsed().as_secs_f64());
    }
    times.sort_by(f64::total_cmp);
    times[times.len() / 2]
}
