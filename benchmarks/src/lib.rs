//! Benchmarks of the stages of `nextview`.
//!
//! One list of [`stages`](stage::stages) on one [`Workload`](workload::Workload) serves four programs: `cargo
//! bench -p nextview-benchmarks` (wall time), the program `stages` (CPU time, compared with the peers in
//! `peers/`), the program `kernels` (instruction counts) and, over sizes, the program `growth`. The results
//! are in `BENCHMARK.md`.
//!
//! The program `color` compares textures on [painted] objects. The program `authors_code` repairs the
//! [program of the paper's authors](authors), slip by slip.

pub mod alignment;
pub mod authors;
pub mod log_plot;
pub mod network;
pub mod painted;
pub mod plain_files;
pub mod stage;
pub mod workload;

/// A result of a program, for people to read: its error states place and cause.
pub type Outcome<T> = Result<T, Box<dyn std::error::Error>>;

/// Returns whether the variable QUICK is set: programs then only show that they run, and measure nothing.
pub fn is_quick() -> bool {
    std::env::var_os("QUICK").is_some()
}

/// Returns the peak memory of this process, MB (Linux).
pub fn peak_memory_mb() -> Outcome<f64> {
    let status = std::fs::read_to_string("/proc/self/status")?;
    let line =
        status.lines().find(|line| line.starts_with("VmHWM")).ok_or("no VmHWM in /proc/self/status")?;
    let kb: f64 = line.split_whitespace().nth(1).ok_or("no number after VmHWM")?.parse()?;
    Ok(kb / 1024.0)
}
