//! The measure of a scan's progress: the best one with known values.

use super::input::ScanPage;
use nextview::planner::Outlook;
use nextview_scan::StepRecord;

/// A share of the surface after each view.
pub(super) struct CoverageCurve {
    /// Heading that names the whole of which it is a share.
    pub name: &'static str,
    /// For each step.
    pub values: Vec<Option<f64>>,
    /// Whether it is comparable with the baselines.
    pub is_reachable: bool,
}

type Measure = (&'static str, fn(&StepRecord) -> Option<f64>);

/// The fairest first. Without baselines, the reachable part is unknown. Without the truth, the whole surface
/// is unknown, and the planner's estimate takes its place.
const MEASURES: [Measure; 3] = [
    ("Reachable coverage", |step| step.reachable_coverage),
    ("Surface within 2 mm", |step| step.surface_coverage_2mm),
    ("Voxel coverage", |step| step.voxel_coverage),
];

/// The best known measure; `None` if the truth is not known.
pub(super) fn known(page: &ScanPage<'_>) -> Option<CoverageCurve> {
    let of = |(i, (name, measure)): (usize, &Measure)| {
        let values: Vec<Option<f64>> = page.steps().iter().map(measure).collect();
        values.iter().any(Option::is_some).then_some(CoverageCurve { name, values, is_reachable: i == 0 })
    };
    MEASURES.iter().enumerate().find_map(of)
}

/// The planner's estimate of the share of the visible surface seen after each view, made when it chose the
/// next one.
pub(super) fn estimated(page: &ScanPage<'_>) -> Vec<Option<f64>> {
    let next = page.next.and_then(|next| next.outlook.as_ref()).map(Outlook::completeness);
    let after = page.steps().iter().skip(1).map(|step| step.estimated_completeness);
    after.chain([next]).take(page.steps().len()).collect()
}
