use crate::{Failure, stdout};
use clap::Args;
use nextview_campaign::{statistics, store};
use nextview_report::comparison_text;
use std::path::PathBuf;

/// Compare two campaigns run by run: is B better than A, and is that more than noise?
///
/// Runs of the same object, variant, seed, view seed and first view are paired. Differences are B - A, mean
/// and median over objects, with 95 % intervals from a bootstrap over objects and their runs, and p from
/// Wilcoxon's signed-rank test over objects. If A and B have one variant each, these two are compared,
/// whatever their names.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  nextview compare before after\n  nextview compare max-flow apora --json"
)]
pub(super) struct CompareArgs {
    /// A campaign's folder
    a: PathBuf,
    /// The folder of the campaign to compare with it
    b: PathBuf,
    /// Print one JSON object instead of text
    #[arg(long)]
    json: bool,
}

impl CompareArgs {
    pub fn run(self) -> Result<(), Failure> {
        let (a, b) = (store::read(&self.a)?, store::read(&self.b)?);
        let comparison = statistics::compare(&a, &b)?;
        if self.json {
            return stdout::print(serde_json::to_string(&comparison).map_err(Failure::data)? + "\n");
        }
        stdout::print(comparison_text(&comparison, &self.a.to_string_lossy(), &self.b.to_string_lossy()))
    }
}
