use super::values;
use crate::{Failure, files, stdout};
use clap::{Args, ValueEnum};
use glam::DVec3;
use nextview::view::{ViewSpace, generate};
use std::path::PathBuf;

/// Write view candidates: camera poses around an object, as CSV.
///
/// Columns: x_m, y_m, z_m, qx, qy, qz, qw, the pose of the camera in the world (world_from_camera, quaternion with the
/// scalar last). All look at the centre, with a level horizon.
#[derive(Debug, Args)]
#[command(
    after_help = "Example:\n  nextview views --rule hemisphere --center 0,0,0.05 --size-m 0.1 --count 200 --out views.csv"
)]
pub(super) struct ViewsArgs {
    /// Where the cameras stand
    #[arg(long, value_enum, default_value = "shell")]
    rule: Rule,
    /// Centre of the object in metres: x,y,z
    #[arg(long, value_name = "X,Y,Z", default_value = "0,0,0", value_parser = values::point, allow_hyphen_values = true)]
    center: DVec3,
    /// Half the longest side of the object's box in metres; cameras stand 2 to 4 (shell) or 3 times as far away
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
}

/// A rule that makes view candidates.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Rule {
    /// The paper's random shell: outside the cube of half-side 2 x size, inside the sphere of radius 4 x size
    Shell,
    /// A Fibonacci sphere of radius 3 x size
    Sphere,
    /// The upper half of it, for an object on a table
    Hemisphere,
}

impl Rule {
    /// The candidates around an object of this centre and half-side, metres.
    pub fn views(self, center: DVec3, size: f64, n: usize, seed: u64) -> Result<ViewSpace, nextview::Error> {
        match self {
            Self::Shell => generate::shell(center, size, n, seed),
            Self::Sphere => generate::fibonacci_sphere(center, 3.0 * size, n),
            Self::Hemisphere => generate::hemisphere(center, 3.0 * size, n),
        }
    }
}

impl ViewsArgs {
    pub fn run(self) -> Result<(), Failure> {
        let views = self.rule.views(self.center, self.size_m, self.count, self.seed)?;
        match &self.out {
            Some(path) => files::write(path, |writer| Ok(views.write_csv(writer)?)),
            None => {
                let mut csv = Vec::new();
                views.write_csv(&mut csv)?;
                stdout::print(csv)
            }
        }
    }
}
