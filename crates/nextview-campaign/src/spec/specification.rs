use super::{FirstViews, ObjectSpec, VariantSpec};
use nextview_scan::Fault;
use serde::Serialize;
use toml::Table;

/// The objects and configurations of a campaign.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Spec {
    /// Name of the campaign, valid as a folder name: letters, digits, `-`, `_` and `.`, without a leading
    /// dot.
    pub name: String,
    /// Seed of all random draws; by default 0. The draws of a run also depend on its object and repetition.
    pub seed: u64,
    /// Repetitions with other random draws, for variants without their own; by default 0 alone.
    pub seeds: Vec<u64>,
    /// Sets of candidates for variants without their own; by default that of the configured `view_seed`, or
    /// else 0.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub view_seeds: Option<Vec<u64>>,
    /// First views for variants without their own; by default 0 alone.
    pub first_views: FirstViews,
    /// Objects to scan; by default all built-in objects.
    pub objects: Vec<ObjectSpec>,
    /// Keys of [`ScanConfig`](nextview_scan::ScanConfig) for all runs.
    pub scan: Table,
    /// The planners with their parameters; by default one, with only the keys of `scan`.
    pub variant: Vec<VariantSpec>,
}

impl Spec {
    /// Name of the file in a campaign's folder.
    pub(crate) const FILE: &'static str = "spec.toml";

    /// The specification as TOML, for [`Spec::of_folder`].
    pub(crate) fn to_toml(&self) -> Result<String, Fault> {
        toml::to_string(self).map_err(Fault::data)
    }
}
