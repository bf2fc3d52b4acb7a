//! Runs one stage once, to count its instructions: the counted part runs in [`counted`], on one thread.
//!
//!     kernels                  # the names of the stages that are small enough
//!     kernels FOLDER NAME      # runs one on the workload in the folder

use nextview_benchmarks::stage::{Stage, TimedWork, stages};
use nextview_benchmarks::workload::Workload;
use std::error::Error;
use std::path::Path;

/// Stages too large for instruction counting: parts of their name and case.
const TOO_LARGE: [&str; 5] = ["no voxel missed", "2 mm", "1 mm", "decision; default", "scan"];

fn main() -> Result<(), Box<dyn Error>> {
    let mut args = std::env::args().skip(1);
    let is_small = |stage: &Stage| TOO_LARGE.iter().all(|part| !stage.to_string().contains(part));
    let mut stages = stages().into_iter().filter(is_small);
    let Some(folder) = args.next() else {
        stages.for_each(|stage| println!("{stage}"));
        return Ok(());
    };
    let name = args.next().ok_or("usage: kernels [FOLDER NAME]")?;
    let stage = stages.find(|stage| stage.to_string() == name).ok_or_else(|| format!("no stage {name}"))?;
    // Worker threads would be counted separately.
    rayon::ThreadPoolBuilder::new().num_threads(1).use_current_thread().build_global()?;
    let workload = Workload::read(Path::new(&folder))?;
    counted(&mut stage.prepare(&workload));
    Ok(())
}

/// Named in `instructions.sh`.
#[inline(never)]
fn counted(work: &mut TimedWork<'_>) {
    work();
}
