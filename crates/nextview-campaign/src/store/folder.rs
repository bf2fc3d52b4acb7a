use super::RUNS;
use crate::{Shard, tables};
use nextview_scan::files::numbered;
use std::path::{Path, PathBuf};

/// Returns the default folder of the campaign with this name: `bench-NAME`, followed by -2, -3, ... if it
/// holds a finished campaign. With `resume`, it is the folder of the last campaign, finished or not.
pub fn campaign_folder(name: &str, resume: bool) -> PathBuf {
    // Tables are written when all runs are done.
    let has_tables = |dir: &Path| tables::FILES.iter().any(|file| dir.join(file).exists());
    let (finished, next) = numbered(&format!("bench-{name}"), |dir| dir.is_file() || has_tables(dir));
    match finished.last() {
        Some(last) if resume && !next.join(RUNS).exists() => last.clone(),
        _ => next,
    }
}

/// Returns the default folder of a shard: `bench-NAME-3-of-64`.
pub fn shard_folder(name: &str, shard: Shard) -> PathBuf {
    let (number, n_shards) = shard.parts();
    format!("bench-{name}-{number}-of-{n_shards}").into()
}
