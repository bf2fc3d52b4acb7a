use super::campaign::counted;
use crate::progress::Progress;
use crate::{Failure, stdout};
use clap::{Args, Subcommand};
use nextview_learned::nbv_net::dataset::{self, DatasetConfig, DatasetError};
use std::path::PathBuf;

/// Make training data for learned planners.
#[derive(Debug, Subcommand)]
#[command(after_help = "Example:\n  nextview dataset nbv-net --out nbv-data")]
pub(super) enum DatasetCommand {
    NbvNet(NbvNetArgs),
}

impl DatasetCommand {
    pub fn run(self) -> Result<(), Failure> {
        match self {
            Self::NbvNet(args) => args.run(),
        }
    }
}

/// Make training data for NBV-Net: the known grid after a few views of an object, and the best of 14 views.
///
/// The simulated camera looks at random objects, which no benchmark has, up to eight times each: from
/// anywhere, from one of the 14 views, or from the best of them. Each view gives a sample: the known grid,
/// and what each of the 14 would truly show. The same objects and seed give the same bytes, for any number of
/// threads and interruptions.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub(super) struct NbvNetArgs {
    /// Folder for the data set
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Number of objects, each of which gives up to eight examples of 33 kB: 2 GB by default
    #[arg(long, value_name = "N", default_value = "8000", value_parser = clap::value_parser!(u32).range(1..=1_000_000), allow_negative_numbers = true)]
    objects: u32,
    /// Seed of the objects and the views
    #[arg(long, value_name = "S", default_value = "0", value_parser = clap::value_parser!(u32), allow_negative_numbers = true)]
    seed: u32,
    /// Resume the data set in the folder
    #[arg(long)]
    resume: bool,
}

const EXAMPLES: &str = "\
Examples:
  nextview dataset nbv-net --out nbv-data
  nextview dataset nbv-net --out nbv-data --resume         resume after an interruption
  nextview dataset nbv-net --out other --objects 100 --seed 1

The folder holds dataset.toml and files of 64 objects, each a NumPy array of records: object (its
number), n_views (taken so far), label (the best view, 0 to 13), seen and gains (surface voxels
that each view sees, and those of them that are new) and grid (32 x 32 x 32 cells, x slowest;
P(occupied) times 254). training/nbv_net.py learns from it.";

impl NbvNetArgs {
    pub fn run(self) -> Result<(), Failure> {
        let config = DatasetConfig { objects: self.objects, seed: self.seed };
        let progress = Progress::new("scanning objects", config.objects as usize);
        dataset::make(&config, &self.out, self.resume, || progress.step()).map_err(failure)?;
        drop(progress);
        let objects = counted(config.objects as usize, "object");
        let files = counted(config.n_files() as usize, "file");
        stdout::print(format!("{objects} in {files} in {}\n", self.out.display()))
    }
}

/// The fault in the words of the command line.
fn failure(error: DatasetError) -> Failure {
    let hint = match &error {
        DatasetError::Exists { .. } => "pass --resume to resume that data set, or another --out".to_owned(),
        DatasetError::Differs { found, .. } => {
            format!("pass --objects {} --seed {}, or another --out", found.objects, found.seed)
        }
        _ => return Failure::data(error),
    };
    Failure::data(error).with_hint(hint)
}
