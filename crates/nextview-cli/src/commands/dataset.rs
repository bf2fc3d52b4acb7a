use super::campaign::counted;
use crate::progress::Progress;
use crate::{Failure, stdout};
use clap::{Args, Subcommand};
use nextview_learned::dataset::{self, DatasetConfig, DatasetError, NetworkName};
use std::path::PathBuf;

/// Make training data for learned planners.
///
/// The simulated camera looks at random objects, none of which is in a benchmark, up to eight times each:
/// from anywhere, from one of the network's views, or from the best of them. Each view gives a sample: what
/// is known at that point, and what each of the network's views would actually show. The same objects and
/// seed give the same bytes, for any number of threads and interruptions.
///
/// The folder holds dataset.toml and files of 64 objects, each a NumPy array of records: object (its number),
/// n_views (taken so far), label (the best view), seen and gains (surface voxels that each view sees, and the
/// new ones among them) and the network's input.
#[derive(Debug, Subcommand)]
#[command(after_help = "Example:\n  nextview dataset nbv-net --out nbv-data")]
pub(super) enum DatasetCommand {
    /// For NBV-Net: the known grid after a few views of an object, and the best of 14 views
    ///
    /// Input: grid (32 x 32 x 32 cells, x slowest; P(occupied) times 254). A sample has 33 kB, so 8000
    /// objects make 2 GB. training/nbv_net.py learns from it.
    #[command(after_help = EXAMPLES)]
    NbvNet(DatasetArgs),
    /// For NBV regression: the known grid after a few views of an object, and the best of 128 views
    ///
    /// Input: grid (32 x 32 x 32 cells, x slowest; P(occupied) times 254). A sample has 34 kB, so 8000
    /// objects make 2 GB. training/nbv_regression.py learns from it.
    #[command(after_help = "Example:\n  nextview dataset nbv-regression --out regression-data")]
    NbvRegression(DatasetArgs),
    /// For PC-NBV: points after a few views of an object, and what each of 33 views would show
    ///
    /// Input: surface (voxels of the object), visited (which of the 33 views) and points (128, in units of
    /// the box). A sample has 1.8 kB, so 8000 objects make 0.1 GB. training/pc_nbv.py learns from it.
    #[command(after_help = "Example:\n  nextview dataset pc-nbv --out pc-data")]
    PcNbv(DatasetArgs),
}

impl DatasetCommand {
    pub fn run(self) -> Result<(), Failure> {
        match self {
            Self::NbvNet(args) => args.run(NetworkName::NbvNet),
            Self::NbvRegression(args) => args.run(NetworkName::NbvRegression),
            Self::PcNbv(args) => args.run(NetworkName::PcNbv),
        }
    }
}

#[derive(Debug, Args)]
pub(super) struct DatasetArgs {
    /// Folder for the data set
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Number of objects, each of which gives up to eight examples
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
  nextview dataset nbv-net --out other --objects 100 --seed 1";

impl DatasetArgs {
    fn run(self, network: NetworkName) -> Result<(), Failure> {
        let config = DatasetConfig { network, objects: self.objects, seed: self.seed };
        let progress = Progress::new("scanning objects", config.objects as usize);
        dataset::make(&config, &self.out, self.resume, || progress.step()).map_err(failure)?;
        drop(progress);
        let objects = counted(config.objects as usize, "object");
        let files = counted(config.n_files() as usize, "file");
        stdout::print(format!("{objects} in {files} in {}\n", self.out.display()))
    }
}

/// Words the fault for the command line.
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
