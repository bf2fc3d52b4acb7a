//! The scene of the live page: what the 3D view shows, and the texts around it.

use super::input::ScanPage;
use super::page::{subtitle, summary_table};
use super::picture::ViewPicture;
use super::shown::ShownModel;
use super::summary::summary;
use super::{chart, headline, steps, thumbnail, viewer};
use nextview::session::NextView;
use nextview_scan::{FinishedScan, Measured, ScanConfig, ScanRecord, short_name};
use serde_json::json;

/// Maximum number of vertices of the surface, 26 bytes each: an update is to stay below 300 kB.
const MAX_VERTICES: usize = 9000;

/// Maximum number of points in an update, 8 bytes each, and of all points.
const MAX_POINTS: [usize; 2] = [6000, 60_000];

pub(crate) fn scene(
    scan: &FinishedScan<'_>,
    config: &ScanConfig,
    next: Option<&NextView>,
    after: usize,
) -> String {
    let record = &scan.record(config, Measured::Nothing).unwrap_or_else(|_| ScanRecord {
        object: short_name(&config.object),
        stop_reason: scan.stop_reason,
        steps: scan.steps.clone(),
        ..ScanRecord::default()
    });
    let candidates: Vec<_> = scan.session.views().poses().iter().map(|pose| pose.translation()).collect();
    let page = &ScanPage {
        record,
        config,
        views: &ViewPicture::of_scan(scan),
        candidates: &candidates,
        model: &ShownModel::of_scan(scan, MAX_VERTICES),
        next,
        command: "",
        config_text: "",
    };
    let after = after.min(page.steps().len());
    let members = viewer::scene(page, after, MAX_POINTS[usize::from(after == 0)]);
    format!(r#"{{{members},"panels":{}}}"#, panels(page, after))
}

/// The parts of the page around the 3D view, as HTML; pictures of the views after number `after` only.
fn panels(page: &ScanPage<'_>, after: usize) -> serde_json::Value {
    // Of the first view alone, so that the colours of pictures that were sent stay right.
    let range = thumbnail::Range::of(page.views.first().map(|picture| picture.depth));
    let pictures: Vec<String> =
        (after..page.steps().len()).map(|i| steps::pictures(page, range, i)).collect();
    json!({
        "title": page.record.object,
        "subtitle": subtitle(page),
        "headline": headline::draw(page),
        "chart": chart::draw(page),
        "measures": summary_table(&summary(page.record, page.config)),
        "views": steps::table_with(page, range, |_| String::new()),
        "pictures": pictures,
    })
}
