use super::document::Document;
use super::setup::Setup;
use super::{calibration, data, figures, html, markdown, paper, setup, summary};
use nextview_campaign::statistics::{Study, StudyBuilder};
use nextview_campaign::store::StoredRuns;
use nextview_scan::Fault;

/// The names of the files of a report: the page, as HTML and as Markdown, and its numbers.
pub const CAMPAIGN_REPORT_FILES: [&str; 8] = [
    "report.html",
    "report.md",
    "setup.csv",
    "statistics.csv",
    "progress.csv",
    "objects.csv",
    "differences.csv",
    "estimates.csv",
];

/// Returns the [`CAMPAIGN_REPORT_FILES`] of a campaign by name, even while it is running. Equal campaigns
/// give equal bytes. Fails if a record cannot be read.
pub fn campaign_report(campaign: &StoredRuns) -> Result<Vec<(&'static str, String)>, Fault> {
    let (mut study, mut setup) = (StudyBuilder::default(), Setup::default());
    for run in campaign.runs.iter() {
        let run = run?;
        study.add(&run);
        setup.add(&run);
    }
    let document = document(campaign, &setup, &study.build());
    let pages = [("report.html", html::render(&document)), ("report.md", markdown::render(&document))];
    Ok(pages.into_iter().chain(data::render(&document)).collect())
}

/// Returns whether a text is a file of such a report, which a newer one may replace.
pub fn is_campaign_report(text: &str) -> bool {
    let is_html = text.starts_with("<!DOCTYPE html>") && text.contains(" – nextview campaign</title>");
    let is_markdown =
        text.starts_with("# ") && text.lines().nth(2).is_some_and(|line| line.starts_with(SUBTITLE));
    is_html || is_markdown || data::is_data(text)
}

/// Start of the line below the title.
const SUBTITLE: &str = "campaign of ";

fn document(campaign: &StoredRuns, setup: &Setup, study: &Study) -> Document {
    let (n_variants, n_objects) = (study.variants.len(), study.objects.len());
    let sections = [
        Some(setup::section(setup, study, campaign.torn)),
        Some(figures::section(study)).filter(|section| !section.blocks.is_empty()),
        Some(summary::section(study)),
        calibration::section(study),
        Some(paper::object_table(study)),
        paper::tables(study),
    ];
    Document {
        title: campaign.name.clone(),
        subtitle: format!("{SUBTITLE}{} runs · {n_variants} variants · {n_objects} objects", study.n_runs),
        sections: sections.into_iter().flatten().collect(),
        setup: setup::rows(setup, study),
    }
}
