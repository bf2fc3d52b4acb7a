//! The coverage curve of a scan beside those it is compared with.

use super::plot::{Axis, Curve, Marker, Plot, legend_item};
use super::{RandomCurve, ScanReport};

/// The chart with its legend; a sentence if no coverage is known.
pub fn draw(report: &ScanReport) -> String {
    let curves = curves(report);
    if curves[0].points.is_empty() {
        return r#"<p class="note">Coverage is not known for this scan.</p>"#.to_owned();
    }
    let legend = legend(report, &curves);
    let plot = Plot {
        x_axis: Axis::Views,
        y_label: "reachable coverage".to_owned(),
        y_range: [0.0, 1.0],
        size: [378.0, 130.0, 294.0],
        curves,
    };
    plot.draw() + &legend
}

/// This scan, then what it is compared with.
fn curves(report: &ScanReport) -> Vec<Curve> {
    let curve = |class: &str, label: &str, marker, coverage: Vec<Option<f64>>| Curve {
        class: class.to_owned(),
        label: label.to_owned(),
        marker,
        points: known(coverage),
        band: Vec::new(),
    };
    let all_known = |coverage: &[f64]| coverage.iter().copied().map(Some).collect();
    let scan = report.steps.iter().map(|s| s.coverage).collect();
    let mut curves = vec![curve("scan", "this scan", Marker::Circle, scan)];
    if let Some(coverage) = &report.clairvoyant {
        curves.push(curve("clairvoyant", "clairvoyant", Marker::Triangle, all_known(coverage)));
    }
    if let Some(random) = &report.random {
        let mean = curve("random", "random", Marker::Square, all_known(&random.mean));
        curves.push(Curve { band: band(random), ..mean });
    }
    curves
}

fn known(coverage: Vec<Option<f64>>) -> Vec<(usize, f64)> {
    let known = |(i, c): (usize, Option<f64>)| Some((i + 1, c.filter(|c| c.is_finite())?.clamp(0.0, 1.0)));
    coverage.into_iter().enumerate().filter_map(known).collect()
}

/// The area between the lower and the upper curve of the random scans.
fn band(random: &RandomCurve) -> Vec<(usize, f64, f64)> {
    let edges = random.low.iter().zip(&random.high).enumerate();
    let edges = edges.map(|(i, (&low, &high))| (i + 1, low, high)).take(random.mean.len());
    edges.filter(|(_, low, high)| low.is_finite() && high.is_finite()).collect()
}

fn legend(report: &ScanReport, curves: &[Curve]) -> String {
    let mut items = String::new();
    for curve in curves {
        let text = match curve.class.as_str() {
            "scan" => format!("this scan ({})", report.planner),
            "clairvoyant" => "clairvoyant: knows the object".to_owned(),
            _ => "random views, mean".to_owned(),
        };
        items += &legend_item(&curve.class, Some(curve.marker), &text);
    }
    if let Some(random) = &report.random {
        items += &legend_item("random", None, &format!("random views, {}", random.band));
    }
    format!(r#"<ul class="legend">{items}</ul>"#)
}
