use super::input::ScanPage;
use super::page::scan_page;
use super::picture::ViewPicture;
use nextview_scan::{FinishedScan, ScanConfig, ScanRecord};

/// The [page](scan_page) of a scan and of its record, with the command that runs it again and its resolved
/// configuration as text.
pub fn page_of_scan(
    scan: &FinishedScan<'_>,
    record: &ScanRecord,
    config: &ScanConfig,
    command: &str,
    config_text: &str,
) -> String {
    let candidates: Vec<_> = scan.session.views().poses().iter().map(|pose| pose.translation()).collect();
    let views = &ViewPicture::of_scan(scan);
    scan_page(&ScanPage { record, config, views, candidates: &candidates, command, config_text })
}
