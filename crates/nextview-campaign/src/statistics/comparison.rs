use super::{Interval, Measure, SignedRank};
use serde::Serialize;

/// The differences between campaign A and campaign B.
#[derive(Clone, Debug, Serialize)]
pub struct Comparison {
    /// Number of runs of A.
    pub n_runs_a: usize,
    /// Number of runs of B.
    pub n_runs_b: usize,
    /// Number of runs in both, including failed ones.
    pub n_pairs: usize,
    /// Runs of A missing in B.
    pub only_in_a: Vec<String>,
    /// Runs of B missing in A.
    pub only_in_b: Vec<String>,
    /// Runs in both that failed in A only.
    pub failed_only_in_a: Vec<String>,
    /// Runs in both that failed in B only.
    pub failed_only_in_b: Vec<String>,
    /// Whether all pairs are equal, ignoring times and memory.
    pub pairs_are_identical: bool,
    /// The variants in both, or the only one of A and the only one of B.
    pub variants: Vec<VariantComparison>,
}

/// A variant of A and one of B on their common objects.
#[derive(Clone, Debug, Serialize)]
pub struct VariantComparison {
    /// Label in A.
    pub variant_a: String,
    /// Label in B.
    pub variant_b: String,
    /// Number of objects with a pair of measured runs.
    pub n_objects: usize,
    /// The compared measures.
    pub measures: Vec<MeasureComparison>,
    /// Objects with a voxel coverage in B better by more than 0.1 point: name and difference in points,
    /// largest first, at most ten.
    pub better: Vec<(String, f64)>,
    /// Objects with a voxel coverage in B worse by more than 0.1 point, in the same form.
    pub worse: Vec<(String, f64)>,
}

/// A measure of a variant over the objects that have it in both campaigns, in the displayed unit.
#[derive(Clone, Debug, Serialize)]
pub struct MeasureComparison {
    /// Name with the displayed unit.
    pub name: &'static str,
    /// Mean in A.
    pub a: f64,
    /// Mean in B.
    pub b: f64,
    /// Median in A.
    pub median_a: f64,
    /// Median in B.
    pub median_b: f64,
    /// Mean of B - A; for times, the mean of B divided by that of A.
    pub difference: f64,
    /// Median of B - A over objects; for times, of B / A.
    pub median_difference: f64,
    /// 95 % interval of the difference by a paired bootstrap over objects and their runs; `None` for a single
    /// run.
    pub interval: Option<Interval>,
    /// Signed-rank test of B - A, paired by object.
    pub test: SignedRank,
    /// Whether the interval excludes "no difference".
    pub is_more_than_noise: bool,
    /// Whether the mean of B is better; `None` if the means are equal.
    pub b_is_better: Option<bool>,
    /// Whether the differences are ratios B / A.
    pub is_ratio: bool,
    /// The measure, for display.
    #[serde(skip)]
    pub measure: Measure,
}

impl Comparison {
    /// Returns whether A and B have the same runs with the same results, ignoring times and memory.
    pub fn is_identical(&self) -> bool {
        self.pairs_are_identical && self.only_in_a.is_empty() && self.only_in_b.is_empty()
    }
}
