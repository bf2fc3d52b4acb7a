use super::{FirstViews, ObjectSpec, VariantSpec};
use nextview_scan::Fault;
use serde::Serialize;
use toml::Table;

/// What to scan, and how.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Spec {
    /// Name of the campaign, which may name a folder: letters, digits, `-`, `_` and `.`, not beginning with a
    /// dot.
    pub name: String,
    /// Seed of all random draws; by default 0. Those of a run depend on its object and repetition as well.
    pub seed: u64,
    /// Repetitions with other random draws, of all variants that have none of their own; by default 0 alone.
    pub seeds: Vec<u64>,
    /// Sets of candidates of all variants that have none of their own; by default that of the configured
    /// `view_seed`, or else 0.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub view_seeds: Option<Vec<u64>>,
    /// First views of all variants that have none of their own; by default 0 alone.
    pub first_views: FirstViews,
    /// What to scan; by default all built-in objects.
    pub objects: Vec<ObjectSpec>,
    /// Keys of [`ScanConfig`](nextview_scan::ScanConfig) for all runs.
    pub scan: Table,
    /// The planners with their parameters; by default one, with nothing beyond `scan`.
    pub variant: Vec<VariantSpec>,
}

impl Spec {
    /// Name of the file in a campaign's folder.
    pub(crate) const FILE: &'static str = "spec.toml";

    /// The specification as TOML, as [`Spec::of_folder`] reads it.
    pub(crate) fn to_toml(&self) -> Result<String, Fault> {
        toml::to_string(self).map_err(Fault::data)
    }
}
