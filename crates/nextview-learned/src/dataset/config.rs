use super::NetworkName;
use serde::{Deserialize, Serialize};

/// The configuration of a data set.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DatasetConfig {
    /// The network to train; NBV-Net if a data set does not state it.
    #[serde(default)]
    pub network: NetworkName,
    /// Number of objects.
    pub objects: u32,
    /// Seed of the objects and of their scans.
    pub seed: u32,
}

impl DatasetConfig {
    /// Number of objects per file: enough for all threads, and few enough to hold their samples in memory and
    /// to lose little work.
    pub(super) const PER_FILE: u32 = 64;

    /// Returns the number of files of samples.
    pub fn n_files(&self) -> u32 {
        self.objects.div_ceil(Self::PER_FILE)
    }
}
