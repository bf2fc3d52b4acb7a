use serde::{Deserialize, Serialize};
use std::fs::read_to_string;

/// The machine of a run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Host {
    /// Name of the machine.
    pub name: String,
    /// Name of the processor.
    pub cpu: String,
    /// Number of threads of the run.
    pub n_threads: usize,
}

impl Host {
    /// Describes this machine, as far as the system reports it, with this number of threads.
    pub fn this(n_threads: usize) -> Self {
        let name = read_to_string("/proc/sys/kernel/hostname").ok();
        let name = name.or_else(|| std::env::var("HOSTNAME").or_else(|_| std::env::var("COMPUTERNAME")).ok());
        Self {
            name: name.map_or_else(|| "unknown".to_owned(), |name| name.trim().to_owned()),
            cpu: cpu().unwrap_or_else(|| std::env::consts::ARCH.to_owned()),
            n_threads,
        }
    }
}

fn cpu() -> Option<String> {
    let text = read_to_string("/proc/cpuinfo").ok()?;
    let line = text.lines().find(|line| line.starts_with("model name"))?;
    Some(line.split_once(':')?.1.trim().to_owned())
}
