//! The key figures at the top of the page.

use super::coverage;
use super::input::ScanPage;
use crate::text::{count, metres, percent, seconds};

/// The figures as a description list.
pub(super) fn draw(page: &ScanPage<'_>) -> String {
    let steps = page.steps();
    let mut out = String::new();
    let mut figure = |value: String, label: &str, note: String| {
        out += &format!("<div><dt>{label}</dt><dd>{value}</dd><dd class=\"note\">{note}</dd></div>");
    };
    let known = coverage::known(page);
    let last = |values: &[Option<f64>]| values.last().copied().flatten();
    if let Some((coverage, share)) = known.as_ref().and_then(|known| Some((known, last(&known.values)?))) {
        let random = if coverage.is_reachable { random_mean(page) } else { String::new() };
        figure(percent(share), coverage.name, random);
    }
    let estimates = coverage::estimated(page);
    if let Some(share) = estimates.iter().flatten().next_back() {
        let views = estimates.iter().rposition(Option::is_some).map_or(0, |i| i + 1);
        figure(percent(*share), "Estimated completeness", format!("by the planner, after {views} views"));
    }
    figure(count(steps.len()), "Views", format!("{} candidates", count(page.record.candidates)));
    figure(metres(steps.last().map_or(0.0, |step| step.path_length_m)), "Path length", String::new());
    // A given first view took no time and says nothing about the planner.
    let mut times: Vec<f64> = steps.iter().map(|step| step.plan_time_ms / 1e3).filter(|&t| t > 0.0).collect();
    times.sort_by(f64::total_cmp);
    if let Some(longest) = times.last() {
        let median = times[times.len() / 2];
        figure(seconds(median), "Planning a view", format!("median; longest {}", seconds(*longest)));
    }
    let n_voxels = steps.iter().map(|step| step.new_voxels).sum();
    figure(count(page.n_points()), "Measured points", format!("{} voxels", count(n_voxels)));
    format!(r#"<dl class="headline">{out}</dl>"#)
}

/// The coverage of random views with the same number of views.
fn random_mean(page: &ScanPage<'_>) -> String {
    let mean = page.record.random_curve.as_ref().and_then(|curve| curve.get(page.steps().len() - 1));
    mean.map_or_else(String::new, |mean| format!("random views: {}", percent(*mean)))
}
