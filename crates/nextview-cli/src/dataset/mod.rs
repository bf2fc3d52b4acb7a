//! `nextview dataset`: examples to learn from, made by the simulator.

mod folder;
mod lesson;
mod npy;

use crate::scan::Progress;
use crate::{Failure, stdout};
use folder::Folder;
use lesson::Sample;
use nextview_sim::SimError;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// Objects of a file: enough for all threads, and few enough to hold their samples in memory and to lose little work.
const PER_FILE: u32 = 64;

/// What decides a data set.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct DatasetConfig {
    /// Number of objects.
    pub objects: u32,
    /// Which objects, and how they are looked at.
    pub seed: u32,
}

/// What to make, and where.
#[derive(Debug)]
pub(crate) struct Request {
    pub config: DatasetConfig,
    /// The folder.
    pub out: PathBuf,
    /// Whether to go on with a data set that is in the folder.
    pub resume: bool,
}

/// Makes the files that are not there yet.
pub(crate) fn make(request: &Request) -> Result<(), Failure> {
    let Request { config, out, resume } = request;
    let folder = Folder::open(out, config, *resume)?;
    let progress = Progress::new("scanning objects", config.objects as usize);
    for first in (0..config.objects).step_by(PER_FILE as usize) {
        let objects = first..config.objects.min(first + PER_FILE);
        if folder.has(first) {
            objects.for_each(|_| progress.step());
            continue;
        }
        folder.write(first, &samples(objects, config.seed, || progress.step())?)?;
    }
    drop(progress);
    let n_files = config.objects.div_ceil(PER_FILE);
    stdout::print(format!("{} objects in {n_files} files in {}\n", config.objects, out.display()))
}

/// The samples of all objects, one object after the other, whichever is finished first.
fn samples(
    objects: std::ops::Range<u32>,
    seed: u32,
    progress: impl Fn() + Sync,
) -> Result<Vec<Sample>, SimError> {
    let samples = |object| lesson::samples(object, seed).inspect(|_| progress());
    let parts: Vec<Vec<Sample>> = objects.into_par_iter().map(samples).collect::<Result<_, _>>()?;
    Ok(parts.into_iter().flatten().collect())
}
