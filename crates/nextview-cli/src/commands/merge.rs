use super::campaign::{check, counted};
use crate::{Failure, stdout};
use clap::Args;
use nextview_campaign::store;
use std::path::PathBuf;

/// Merge the shards of a campaign.
///
/// Apart from times, the tables are the same to the byte as those of a campaign run by one process. Every run
/// must be present and computed by this build of the program; identical duplicates count once. All faults are
/// reported at once, and then nothing is written. The shards are not changed.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  nextview merge bench-mine-*-of-64 --out mine\n  nextview merge a b c --out whole"
)]
pub(super) struct MergeArgs {
    /// The folders of all shards, in any order
    #[arg(required = true, value_name = "DIR")]
    dirs: Vec<PathBuf>,
    /// Folder for the campaign, which must be new or empty
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
}

impl MergeArgs {
    pub fn run(self) -> Result<(), Failure> {
        let merged = store::merge(&self.dirs, &self.out)?;
        for dir in &merged.torn {
            eprintln!(
                "note: the last line of {} is incomplete and was left out",
                dir.join("runs.jsonl").display()
            );
        }
        let (runs, folders) = (counted(merged.n_runs, "run"), counted(self.dirs.len(), "folder"));
        let repeated = match merged.n_repeated {
            0 => String::new(),
            n => format!(", {}", counted(n, "identical duplicate")),
        };
        stdout::print(format!("{runs} of {folders}{repeated}; results in {}\n", self.out.display()))?;
        check(&merged.failed, merged.n_runs)
    }
}
