//! The statistics of campaigns: the numbers of a run, a campaign by variant and object, and the comparison of
//! two campaigns. All of it is data from records; pages and texts are made elsewhere.

mod compare;
mod comparison;
mod interval;
pub mod measure;
mod measured_run;
mod sample;
mod signed_rank;
mod study;

pub use compare::compare;
pub use comparison::{Comparison, MeasureComparison, VariantComparison};
pub use interval::{Interval, deviation, mean, percentile};
pub use measure::{Better, Measure};
pub use measured_run::{Curve, MeasuredRun, MeasuredStep};
pub use sample::{PairedObject, PairedSample, Sample};
pub use signed_rank::{SignedRank, signed_rank};
pub use study::{Study, StudyBuilder, StudyObject, StudyVariant};

#[cfg(test)]
mod tests;
