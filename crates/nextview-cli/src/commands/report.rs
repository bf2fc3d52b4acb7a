use crate::{Failure, stdout};
use clap::Args;
use nextview_campaign::store;
use nextview_report::{CAMPAIGN_REPORT_FILES, campaign_report, is_campaign_report};
use nextview_scan::files::{self, Overwrite, ResultFolder};
use std::io::Write;
use std::path::PathBuf;

/// Write the report of a campaign: figures and tables as HTML and as Markdown.
///
/// Reads runs.jsonl in the campaign's folder, even while the campaign is running, and writes report.html and
/// report.md next to it: the setup, coverage and entropy over the views, the results and costs of each
/// variant with intervals and paired differences, and the tables of the paper with its published numbers. The
/// numbers are also written as setup.csv, statistics.csv, progress.csv, objects.csv, differences.csv and
/// estimates.csv.
#[derive(Debug, Args)]
#[command(after_help = "Example:\n  nextview report campaign")]
pub(super) struct ReportArgs {
    /// The campaign's folder
    dir: PathBuf,
    /// Replace files of these names even if they are not part of a campaign report
    #[arg(long)]
    force: bool,
}

/// Maximum size of a recognised report in bytes.
const MAX_BYTES: u64 = 1 << 28;

impl ReportArgs {
    pub fn run(self) -> Result<(), Failure> {
        let campaign = store::read(&self.dir)?;
        let files = campaign_report(&campaign)?;
        let may_replace = || CAMPAIGN_REPORT_FILES.iter().all(|name| self.may_replace(name));
        let rule = Overwrite::forced(self.force || may_replace());
        let mut folder = ResultFolder::begin(&self.dir, &CAMPAIGN_REPORT_FILES, rule)?;
        for (name, text) in files {
            folder.add(name, |w| Ok(w.write_all(text.as_bytes())?))?;
        }
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
