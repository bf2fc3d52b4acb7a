//! The five figures at the top of the page.

use super::ScanReport;
use super::text::{count, metres, percent, seconds};

/// The figures as a description list.
pub fn draw(report: &ScanReport) -> String {
    let steps = &report.steps;
    let mut out = String::new();
    let mut figure = |value: String, label: &str, note: String| {
        out += &format!("<div><dt>{label}</dt><dd>{value}</dd><dd class=\"note\">{note}</dd></div>");
    };
    if let Some(coverage) = steps.last().and_then(|s| s.coverage) {
        figure(percent(coverage), "Reachable coverage", random_mean(report));
    }
    figure(count(steps.len()), "Views", format!("{} candidates", count(report.candidates.len())));
    let travel: f64 = steps.iter().map(|s| s.travel).sum();
    figure(metres(travel), "Camera path", String::new());
    // A first view that was given and not chosen took no time and says nothing about the planner.
    let mut times: Vec<f64> = steps.iter().map(|s| s.plan_time).filter(|&t| t > 0.0).collect();
    times.sort_by(f64::total_cmp);
    if let Some(longest) = times.last() {
        let median = times[times.len() / 2];
        figure(seconds(median), "Planning a view", format!("median; longest {}", seconds(*longest)));
    }
    let n_points = steps.iter().map(|s| s.points.len()).sum();
    let n_voxels = steps.iter().map(|s| s.new_voxels).sum();
    figure(count(n_points), "Measured points", format!("{} voxels", count(n_voxels)));
    format!(r#"<dl class="headline">{out}</dl>"#)
}

/// What random scans reach with the same number of views.
fn random_mean(report: &ScanReport) -> String {
    let mean = report.random.as_ref().and_then(|r| r.mean.get(report.steps.len() - 1));
    mean.map_or_else(String::new, |mean| format!("random views: {}", percent(*mean)))
}
