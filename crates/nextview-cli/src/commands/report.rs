use crate::{Failure, stdout};
use clap::Args;
use nextview_campaign::store;
use nextview_report::campaign_report;
use nextview_scan::files::ResultFolder;
use std::io::Write;
use std::path::PathBuf;

/// Write the report of a campaign: figures and tables as HTML and as Markdown.
///
/// Reads runs.jsonl in the campaign's folder, also while the campaign is running, and writes report.html and
/// report.md beside it: what was run, coverage and entropy over the views, what each variant reached and
/// cost, with intervals and paired differences, and the tables of the paper with its published numbers.
#[derive(Debug, Args)]
#[command(after_help = "Example:\n  nextview report campaign")]
pub(super) struct ReportArgs {
    /// The campaign's folder
    dir: PathBuf,
}

impl ReportArgs {
    pub fn run(self) -> Result<(), Failure> {
        let campaign = store::read(&self.dir)?;
        let [html, markdown] = campaign_report(&campaign);
        let mut folder = ResultFolder::begin(&self.dir)?;
        folder.add("report.html", |w| Ok(w.write_all(html.as_bytes())?))?;
        folder.add("report.md", |w| Ok(w.write_all(markdown.as_bytes())?))?;
        folder.publish()?;
        if campaign.torn {
            eprintln!("note: the last line of runs.jsonl is not whole yet and was left out");
        }
        let path = self.dir.join("report.html");
        stdout::print(format!("{} runs; open {}\n", campaign.runs.len(), path.display()))
    }
}
