//! Many scans: the report of a campaign, and the comparison of two as text.
//!
//! The numbers come from [`nextview_campaign::statistics`]; this module turns them into text, tables and
//! drawings.

mod calibration;
mod comparison;
mod data;
mod data_file;
mod document;
mod figures;
mod html;
mod line;
mod markdown;
mod paper;
mod planner_section;
mod report;
mod setup;
mod statistic;
mod summary;
#[cfg(test)]
mod synthetic;
#[cfg(test)]
mod tests;

pub use comparison::comparison_text;
pub use report::{CAMPAIGN_REPORT_FILES, campaign_report, is_campaign_report};
