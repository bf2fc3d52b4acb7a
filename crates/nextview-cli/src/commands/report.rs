use crate::{Failure, stdout};
use clap::Args;
use nextview_campaign::store;
use nextview_report::{campaign_report, is_campaign_report};
use nextview_scan::files::{self, Overwrite, ResultFolder};
use std::io::Write;
use std::path::PathBuf;

/// Write the report of a campaign: figures and tables as HTML and as Markdown.
///
/// Reads runs.jsonl in the campaign's folder, even while the campaign is running, and writes report.html and
/// report.md next to it: the setup, coverage and entropy over the views, the results and costs of each
/// variant with intervals and paired differences, and the tables of the paper with its published numbers.
#[derive(Debug, Args)]
#[command(after_help = "Example:\n  nextview report campaign")]
pub(super) struct ReportArgs {
    /// The campaign's folder
    dir: PathBuf,
    /// Replace report.html and report.md even if they are not campaign reports
    #[arg(long)]
    force: bool,
}

const FILES: &[&str] = &["report.html", "report.md"];

/// Maximum size of a recognised report in bytes.
const MAX_BYTES: u64 = 1 << 28;

impl ReportArgs {
    pub fn run(self) -> Result<(), Failure> {
        let campaign = store::read(&self.dir)?;
        let [html, markdown] = campaign_report(&campaign)?;
        let rule = Overwrite::forced(self.force || FILES.iter().all(|name| self.may_replace(name)));
        let mut folder = ResultFolder::begin(&self.dir, FILES, rule)?;
        folder.add("report.html", |w| Ok(w.write_all(html.as_bytes())?))?;
        folder.add("report.md", |w| Ok(w.write_all(markdown.as_bytes())?))?;
        folder.publish()?;
        if campaign.torn {
            eprintln!("note: the last line of runs.jsonl is incomplete and was left out");
        }
        let path = self.dir.join("report.html");
        stdout::print(format!("{} runs; open {}\n", campaign.runs.len(), path.display()))
    }

    /// Whether the file is an earlier report, or missing.
    fn may_replace(&self, name: &str) -> bool {
        let path = self.dir.join(name);
        !path.exists() || files::read_text(&path, MAX_BYTES).is_ok_and(|text| is_campaign_report(&text))
    }
}
