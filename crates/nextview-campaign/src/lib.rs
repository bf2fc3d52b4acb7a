//! Campaigns: many scans of many objects by one specification, their stored results, and their statistics.
//!
//! ```text
//! Spec ──▶ Run, Run, … ──▶ execution ──▶ RunRecord ──▶ Store (runs.jsonl) ──▶ tables
//!                              │                                        └──▶ statistics: Study, Comparison
//!                              └──▶ CampaignEvent: a program shows progress with these
//! ```
//!
//! Start with [`Spec::load`], open a [`Store`](store::Store) for it, execute the remaining runs with
//! [`run_campaign`](execution::run_campaign), and write the [`tables`]. Several workers can execute a
//! [`Shard`] each; [`store::merge`] combines them into one campaign. A report or a comparison only reads:
//! [`store::read`] and [`statistics`].
//!
//! The crate prints nothing, ends no process and names no command-line option. Scanning itself belongs to
//! `nextview-scan`.

pub mod execution;
mod failed_runs;
mod host;
mod record;
mod runs;
mod seeds;
mod shard;
mod spec;
pub mod statistics;
pub mod store;
#[cfg(test)]
mod synthetic;
pub mod tables;

pub use failed_runs::FailedRuns;
pub use host::Host;
pub use record::{DoneRun, RunRecord, RunResult};
pub use runs::{Run, RunId, Runs};
pub use shard::Shard;
pub use spec::{FirstViews, ObjectSpec, Spec, VariantSpec, builtin};
