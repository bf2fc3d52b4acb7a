//! Campaigns: many scans by one specification, and what is kept of them.

mod record;

pub(crate) use record::{Host, Measures, RunRecord, RunResult, StepMeasures};
