use super::input::ScanPage;
use super::stop_phrase::stop_phrase;
use super::summary::summary;
use super::{chart, headline, placement, steps, viewer};
use crate::text::{STYLE, escape, fill};
use base64::prelude::{BASE64_STANDARD, Engine};
use sha2::{Digest, Sha256};

/// Returns the page of a scan as one HTML file that needs no network. Equal scans give equal bytes.
///
/// Above 100 000 points it shows an even selection of them and stays below 3 MB.
///
/// ```
/// use nextview_report::{ScanPage, ShownModel, scan_page};
/// use nextview_scan::{Profile, ScanConfig, ScanRecord};
///
/// let config = ScanConfig::of_profile(Profile::Default);
/// let record = ScanRecord { object: "mug".to_owned(), ..ScanRecord::default() };
/// let page = scan_page(&ScanPage {
///     record: &record,
///     config: &config,
///     views: &[],
///     candidates: &[],
///     model: &ShownModel::default(),
///     next: None,
///     command: "nextview scan mug.stl",
///     config_text: "",
/// });
/// assert!(page.contains("<h1>mug</h1>") && page.contains("under way"));
/// ```
pub fn scan_page(page: &ScanPage<'_>) -> String {
    let values = [
        ("object", escape(&page.record.object)),
        ("style", STYLE.to_owned()),
        ("subtitle", subtitle(page)),
        ("headline", headline::draw(page)),
        ("chart", chart::draw(page)),
        ("placement", placement::section(page)),
        ("steps", steps::table(page)),
        ("summary", summary_table(&summary(page.record, page.config))),
        ("command", escape(page.command)),
        ("config", escape(page.config_text)),
        ("thinned", viewer::note(page)),
        ("version", env!("CARGO_PKG_VERSION").to_owned()),
        ("figure", viewer::FIGURE.to_owned()),
        ("scene", format!("{{{}}}", viewer::scene(page, 0, viewer::MAX_POINTS))),
        ("script_hash", hash(viewer::REPORT_SCRIPT)),
        ("script", viewer::REPORT_SCRIPT.to_owned()),
    ];
    fill(include_str!("page.html"), &values)
}

/// The hash of the script in the page's policy: no other script runs.
fn hash(script: &str) -> String {
    BASE64_STANDARD.encode(Sha256::digest(format!("\n{script}")))
}

pub(super) fn subtitle(page: &ScanPage<'_>) -> String {
    let record = page.record;
    let state = record.stop_reason.map_or_else(
        || "<b>under way</b>".to_owned(),
        |reason| format!("stopped: <b>{}</b>", escape(stop_phrase(reason))),
    );
    format!(
        "planner <b>{}</b> · profile <b>{}</b> · seed <b>{}</b> · {state}",
        escape(&record.planner.to_string()),
        escape(&record.profile.to_string()),
        record.seed,
    )
}

/// Labels and values, one pair per row.
pub(super) fn summary_table(rows: &[(String, String)]) -> String {
    let row = |(label, value): &(String, String)| {
        let class = if label.starts_with(' ') { r#" class="part""# } else { "" };
        format!(
            r#"<tr><th scope="row"{class}>{}</th><td class="number">{}</td></tr>"#,
            escape(label.trim_start()),
            escape(value)
        )
    };
    let rows: String = rows.iter().map(row).collect();
    format!("<table class=\"summary\"><tbody>{rows}</tbody></table>")
}
