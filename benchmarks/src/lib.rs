//! Benchmarks of the stages of `nextview`.
//!
//! One list of [`stages`](stage::stages) on one [`Workload`](workload::Workload) serves four programs:
//! `cargo bench -p nextview-benchmarks` (wall time), the program `stages` (CPU time, beside the peers in
//! `peers/`), the program `kernels` (instruction counts) and, over sizes, the program `growth`. The results
//! are in `BENCHMARK.md`.
//! The programs `questions`, `ceiling` and `seconds` compare planners on [objects whose truth is
//! known](known_object), the program `color` textures on [painted] objects, the program `purposes` planners
//! by what [purposes of scans need](needs). The program `authors_code` repairs the [program of the paper's
//! authors](authors), slip by slip.

pub mod alignment;
pub mod authors;
pub mod known_object;
pub mod log_plot;
pub mod needs;
pub mod network;
pub mod painted;
pub mod plain_files;
pub mod stage;
pub mod workload;

/// Whether the variable QUICK is set: programs then show that they run, and measure nothing.
pub fn is_quick() -> bool {
    std::env::var_os("QUICK").is_some()
}

/// The largest memory that this process ever held, MB (Linux).
pub fn peak_memory_mb() -> Result<f64, Box<dyn std::error::Error>> {
    let status = std::fs::read_to_string("/proc/self/status")?;
    let line =
        status.lines().find(|line| line.starts_with("VmHWM")).ok_or("no VmHWM in /proc/self/status")?;
    let kb: f64 = line.split_whitespace().nth(1).ok_or("no number after VmHWM")?.parse()?;
    Ok(kb / 1024.0)
}
