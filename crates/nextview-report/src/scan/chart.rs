//! The coverage curve of a scan against the baselines.

use super::coverage::{self, CoverageCurve};
use super::input::ScanPage;
use crate::plot::{CurveMarker, HorizontalAxis, Plot, PlotCurve, legend_item};
use nextview_scan::ScanRecord;

/// The chart with its legend; a sentence if no coverage is known.
pub(super) fn draw(page: &ScanPage<'_>) -> String {
    let coverage = coverage::known(page);
    let curves = curves(page, coverage.as_ref());
    if curves.is_empty() {
        return r#"<p class="note">Coverage is not known for this scan.</p>"#.to_owned();
    }
    let legend = legend(page.record, &curves);
    let plot = Plot {
        x_axis: HorizontalAxis::Views,
        y_label: coverage.map_or("estimated completeness", |coverage| coverage.name).to_lowercase(),
        y_range: [0.0, 1.0],
        size: [378.0, 130.0, 294.0],
        curves,
    };
    plot.draw() + &legend
}

/// The curve of this scan, the planner's estimate, and the baselines, if they have points.
fn curves(page: &ScanPage<'_>, coverage: Option<&CoverageCurve>) -> Vec<PlotCurve> {
    let record = page.record;
    let curve = |class: &str, label: &str, marker, coverage: Vec<Option<f64>>| PlotCurve {
        class: class.to_owned(),
        label: label.to_owned(),
        marker,
        points: known(coverage),
        band: Vec::new(),
    };
    let all_known = |coverage: &[f64]| coverage.iter().copied().map(Some).collect();
    let mut curves = Vec::new();
    if let Some(coverage) = coverage {
        curves.push(curve("scan", "this scan", CurveMarker::Circle, coverage.values.clone()));
    }
    curves.push(curve("estimated", "estimated", CurveMarker::None, coverage::estimated(page)));
    if coverage.is_some_and(|coverage| coverage.is_reachable) {
        if let Some(coverage) = &record.clairvoyant_curve {
            curves.push(curve("clairvoyant", "clairvoyant", CurveMarker::Triangle, all_known(coverage)));
        }
        if let Some(mean) = &record.random_curve {
            let mean = curve("random", "random", CurveMarker::Square, all_known(mean));
            curves.push(PlotCurve { band: band(record), ..mean });
        }
    }
    curves.retain(|curve| !curve.points.is_empty());
    curves
}

fn known(coverage: Vec<Option<f64>>) -> Vec<(usize, f64)> {
    let known = |(i, c): (usize, Option<f64>)| Some((i + 1, c.filter(|c| c.is_finite())?.clamp(0.0, 1.0)));
    coverage.into_iter().enumerate().filter_map(known).collect()
}

/// The area between the 5th and the 95th percentile of random views.
fn band(record: &ScanRecord) -> Vec<(usize, f64, f64)> {
    let edges = record.random_low_curve.iter().flatten().zip(record.random_high_curve.iter().flatten());
    let edges = edges.enumerate().map(|(i, (&low, &high))| (i + 1, low, high));
    edges.filter(|(_, low, high)| low.is_finite() && high.is_finite()).collect()
}

fn legend(record: &ScanRecord, curves: &[PlotCurve]) -> String {
    let mut items = String::new();
    for curve in curves {
        let text = match curve.class.as_str() {
            "scan" => format!("this scan ({})", record.planner),
            "estimated" => "seen, estimated by the planner".to_owned(),
            "clairvoyant" => "clairvoyant: knows the object".to_owned(),
            _ => "random views, mean".to_owned(),
        };
        items += &legend_item(&curve.class, Some(curve.marker), &text);
    }
    if curves.iter().any(|curve| !curve.band.is_empty()) {
        items += &legend_item("random", None, "random views, 5th to 95th percentile");
    }
    format!(r#"<ul class="legend">{items}</ul>"#)
}
