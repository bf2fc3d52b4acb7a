//! Pages and plots of scans and campaigns, from their records alone.
//!
//! Everything here is a function from records to text: it prints nothing and opens no file. Start with
//! [`scan_page`] for one scan, finished or in progress, [`summary`] for its quantities as rows of text, and
//! `campaign_report` for a campaign (feature `campaign`). Pages are single HTML files that need no network.
//! Equal records give equal bytes.

#[cfg(feature = "campaign")]
mod campaign;
pub mod live;
#[cfg_attr(
    not(feature = "campaign"),
    allow(dead_code, unused_imports, reason = "campaigns draw more than scans")
)]
mod plot;
mod scan;
mod text;

#[cfg(feature = "campaign")]
pub use campaign::{CAMPAIGN_REPORT_FILES, campaign_report, comparison_text, is_campaign_report};
pub use scan::{
    ScanPage, ShownModel, ViewPicture, color_png, depth_png, heading, page_of_scan, scan_page, step_line,
    stop_phrase, summary, summary_text,
};
