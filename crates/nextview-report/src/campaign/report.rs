use super::document::Document;
use super::setup::Setup;
use super::{calibration, figures, html, markdown, paper, setup, summary};
use nextview_campaign::statistics::{Study, StudyBuilder};
use nextview_campaign::store::StoredRuns;
use nextview_scan::Fault;

/// Returns the report of a campaign as HTML and as Markdown, even while it is running. Equal campaigns give
/// equal bytes. Fails if a record cannot be read.
pub fn campaign_report(campaign: &StoredRuns) -> Result<[String; 2], Fault> {
    let (mut study, mut setup) = (StudyBuilder::default(), Setup::default());
    for run in campaign.runs.iter() {
        let run = run?;
        study.add(&run);
        setup.add(&run);
    }
    let document = document(campaign, &setup, &study.build());
    Ok([html::render(&document), markdown::render(&document)])
}

/// Returns whether a text is such a report, which a newer one may replace.
pub fn is_campaign_report(text: &str) -> bool {
    let is_html = text.starts_with("<!DOCTYPE html>") && text.contains(" – nextview campaign</title>");
    let is_markdown =
        text.starts_with("# ") && text.lines().nth(2).is_some_and(|line| line.starts_with(SUBTITLE));
    is_html || is_markdown
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
    }
}
