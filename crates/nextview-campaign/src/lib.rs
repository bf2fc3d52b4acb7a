//! Campaigns: many scans of many objects by one specification, what is kept of them, and their statistics.
//!
//! ```text
//! Spec ──▶ Run, Run, … ──▶ execution ──▶ RunRecord ──▶ Store (runs.jsonl) ──▶ tables
//!                              │                                        └──▶ statistics: Study, Comparison
//!                              └──▶ CampaignEvent: a program shows progress with these
//! ```
//!
//! Start with [`Spec::load`], open a [`Store`](store::Store) for it, do the runs that are left with
//! [`run_campaign`](execution::run_campaign), and write the [`tables`]. Several workers do a [`Shard`] each,
//! and [`store::merge`] makes one campaign of theirs. A report or a comparison only reads: [`store::read`]
//! and [`statistics`].
//!
//! The crate prints nothing, ends no process and names no option of a program. How a scan is done is the
//! business of `nextview-scan`.

pub mod execution;
mod failed_runs;
mod host;
#[cfg(test)]
mod made_up;
mod record;
mod runs;
mod seeds;
mod shard;
mod spec;
pub mod statistics;
pub mod store;
pub mod tables;

pub use failed_runs::FailedRuns;
pub use host::Host;
pub use record::{DoneRun, RunRecord, RunResult};
pub use runs::{Run, RunId, Runs};
pub use shard::Shard;
pub use spec::{FirstViews, ObjectSpec, Spec, VariantSpec, builtin};
