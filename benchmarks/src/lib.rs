//! Benchmarks of the stages of `nextview`.
//!
//! One list of [`stages`](stage::stages) on one [`Workload`](workload::Workload) serves four programs: `cargo
//! bench` (wall time), the program `stages` (CPU time, beside the peers in `peers/`), the program `kernels`
//! (instruction counts) and, over sizes, the program `growth`. The results are in `BENCHMARK.md`.

pub mod log_plot;
pub mod network;
pub mod plain_files;
pub mod stage;
pub mod workload;

/// Whether the variable QUICK is set: programs then show that they run, and measure nothing.
pub fn is_quick() -> bool {
    std::env::var_os("QUICK").is_some()
}
