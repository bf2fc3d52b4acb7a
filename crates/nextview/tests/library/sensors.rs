//! The table in `docs/sensors.md` has the figures of the code.

#![allow(clippy::unwrap_used, reason = "helpers of tests")]

use glam::DVec2;
use nextview::sensor::{Intrinsics, Sensor};
use std::path::Path;

/// The start of a sensor's row: name, image, field of view, range, and sigma at 0.3, 0.5 and 1 m.
fn row(sensor: Sensor) -> String {
    let (camera, range) = (sensor.intrinsics(), sensor.depth_range());
    let [across, down] = field_of_view(&camera);
    let sigmas = [0.3, 0.5, 1.0].map(|depth| match (range.min..=range.max).contains(&depth) {
        true => format!("{:.2}", 1e3 * sensor.depth_error().sigma(depth)),
        false => String::new(),
    });
    let optics = format!("{} x {} | {across:.0} x {down:.0}", camera.width(), camera.height());
    format!("| `{sensor}` | {optics} | {} to {} | {} |", range.min, range.max, sigmas.join(" | "))
}

/// Degrees, through the middle of the image from edge to edge.
fn field_of_view(camera: &Intrinsics) -> [f64; 2] {
    let size = DVec2::new(camera.width() as f64, camera.height() as f64);
    std::array::from_fn(|axis| {
        let angle = |pixel: f64| {
            let mut at = camera.center();
            at[axis] = pixel;
            camera.deproject(at).unwrap()[axis].atan()
        };
        (angle(size[axis] - 0.5) - angle(-0.5)).to_degrees()
    })
}

#[test]
fn the_documented_figures_are_those_of_the_code() {
    let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/sensors.md");
    let page = std::fs::read_to_string(page).unwrap();
    let rows: Vec<&str> = page.lines().filter(|line| line.starts_with("| `")).collect();
    for sensor in Sensor::ALL {
        let expected = row(sensor);
        let found =
            rows.iter().any(|row| row.replace("|  |", "| |").starts_with(&expected.replace("|  |", "| |")));
        assert!(found, "docs/sensors.md has no row\n{expected}");
    }
}
