use super::input::ScanPage;
use super::new_points::NewPoints;
use super::page::scan_page;
use super::picture::ViewPicture;
use super::scan_copy::ScanCopy;
use super::shown::{FusedFrames, ShownModel};
use nextview_scan::{ScanConfig, ScanRecord, ScanState};

/// Maximum number of vertices of the surface on a page. A vertex costs 26 bytes, so they take 1 MB.
const MAX_VERTICES: usize = 40_000;

/// Returns the [page](scan_page) of a scan and its record, with the command that repeats it and its resolved
/// configuration as text.
pub fn page_of_scan(
    scan: &ScanState<'_>,
    record: &ScanRecord,
    config: &ScanConfig,
    command: &str,
    config_text: &str,
) -> String {
    let copy = ScanCopy::of(scan);
    let candidates: Vec<_> = copy.candidates.poses().iter().map(|pose| pose.translation()).collect();
    let mut points = NewPoints::default();
    points.update(&copy);
    let views = &ViewPicture::of_copy(&copy, &points);
    let model = &ShownModel::of_copy(&copy, &mut FusedFrames::default(), MAX_VERTICES);
    let candidates = &candidates;
    scan_page(&ScanPage { record, config, views, candidates, model, next: None, command, config_text })
}
