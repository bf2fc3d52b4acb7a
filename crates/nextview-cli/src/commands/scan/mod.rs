//! `nextview scan`: a single scan, simulated or of recorded frames.

mod args;
mod run;

pub(super) use args::ScanArgs;
