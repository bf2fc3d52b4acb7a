use super::values::{self, named};
use crate::{Failure, stdout};
use clap::Args;
use glam::DVec3;
use nextview_scan::files::Overwrite;
use nextview_scan::{ViewRule, files};
use std::path::PathBuf;

/// Write view candidates: camera poses around an object, as CSV.
///
/// Columns: x_m, y_m, z_m, qx, qy, qz, qw, the pose of the camera in the world (world_from_camera, quaternion
/// with the scalar last). All look at the centre, with a level horizon.
#[derive(Debug, Args)]
#[command(
    after_help = "Example:\n  nextview views --rule hemisphere --center 0,0,0.05 --size-m 0.1 --count 200 --out views.csv"
)]
pub(super) struct ViewsArgs {
    /// Where the cameras stand
    #[arg(long, value_parser = named::<ViewRule>(), default_value = "shell")]
    rule: ViewRule,
    /// Centre of the object in metres: x,y,z
    #[arg(long, value_name = "X,Y,Z", default_value = "0,0,0", value_parser = values::point, allow_hyphen_values = true)]
    center: DVec3,
    /// Half the longest side of the object's box in metres; cameras stand 2 to 4 (shell) or 3 times as far
    /// away
    #[arg(long, value_name = "M", default_value = "0.1", value_parser = values::positive, allow_negative_numbers = true)]
    size_m: f64,
    /// Number of candidates
    #[arg(long, value_name = "N", default_value = "1000", value_parser = values::count, allow_negative_numbers = true)]
    count: usize,
    /// Seed of the random shell
    #[arg(long, value_name = "S", default_value = "0", value_parser = values::seed, allow_negative_numbers = true)]
    seed: u64,
    /// File to write [default: stdout]
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    /// Replace the file to write if it exists
    #[arg(long, requires = "out")]
    force: bool,
}

impl ViewsArgs {
    pub fn run(self) -> Result<(), Failure> {
        let views = self.rule.views(self.center, self.size_m, None, self.count, self.seed)?;
        match &self.out {
            Some(path) => {
                let rule = Overwrite::forced(self.force);
                Ok(files::write(path, &rule, |writer| Ok(views.write_csv(writer)?))?)
            }
            None => {
                let mut csv = Vec::new();
                views.write_csv(&mut csv)?;
                stdout::print(csv)
            }
        }
    }
}
