//! The memory of this process in MB; `None` if the system does not report it.

/// Peak memory, since the start or the last [`forget_peak`].
pub fn peak_mb() -> Option<f64> {
    status_mb("VmHWM:")
}

/// Current memory.
pub fn now_mb() -> Option<f64> {
    status_mb("VmRSS:")
}

/// Resets the peak to the current memory; `None` if the system cannot.
pub fn forget_peak() -> Option<()> {
    std::fs::write("/proc/self/clear_refs", "5").ok()
}

fn status_mb(label: &str) -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix(label))?;
    let kilobytes: f64 = line.trim().trim_end_matches("kB").trim().parse().ok()?;
    Some((kilobytes / 102.4).round() / 10.0)
}
