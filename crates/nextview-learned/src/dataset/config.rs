use super::NetworkName;
use serde::{Deserialize, Serialize};

/// The configuration of a data set.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DatasetConfig {
    /// The network to train. Data sets that do not state it are for NBV-Net.
    #[serde(default)]
    pub network: NetworkName,
    /// Number of objects.
    pub objects: u32,
    /// Seed of the objects and of their scans.
    pub seed: u32,
}

impl DatasetConfig {
    /// Objects of a file: enough for all threads, and few enough to hold their samples in memory and to lose
    /// little work.
    pub(super) const PER_FILE: u32 = 64;

    /// Number of files of samples.
    pub fn n_files(&self) -> u32 {
        self.objects.div_ceil(Self::PER_FILE)
    }
}
