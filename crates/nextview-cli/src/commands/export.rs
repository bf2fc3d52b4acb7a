use super::values;
use crate::{Failure, stdout};
use clap::Args;
use nextview_export::Format;
use nextview_scan::files::Overwrite;
use std::path::PathBuf;

/// Export the results of a scan in the format of another tool.
///
/// Reads the folder of a scan: frames with the poses at which they were mapped, cloud, mesh and record. All
/// formats contain the same images, without lens distortion; masks come from the final mesh. colmap,
/// foundationpose, nerfstudio and obj need frames with colour.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub(super) struct ExportArgs {
    /// The folder of the scan
    dir: PathBuf,
    /// The format
    #[arg(long, value_name = "FORMAT", value_parser = values::named::<Format>())]
    to: Format,
    /// The output folder
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Replace existing files
    #[arg(long)]
    force: bool,
}

const EXAMPLES: &str = "\
Examples:
  nextview scan --frames mug.mcap --out mug
  nextview export mug --to obj --out mug-textured
  nextview export mug --to foundationpose --out mug-foundationpose
  nextview export mug --to colmap --out mug-colmap";

impl ExportArgs {
    pub fn run(self) -> Result<(), Failure> {
        let rule = Overwrite::forced(self.force);
        let exported = nextview_export::export(&self.dir, self.to, &self.out, rule)?;
        exported.notes.iter().for_each(|note| eprintln!("note: {note}"));
        stdout::print(format!("{} views as {} in {}\n", exported.n_views, self.to, self.out.display()))
    }
}
