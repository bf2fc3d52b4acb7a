//! The memory of this process, MB; none where the system does not tell.

/// The most it ever held, or has held since [`forget_peak`].
pub(crate) fn peak_mb() -> Option<f64> {
    status_mb("VmHWM:")
}

/// What it holds now.
pub(crate) fn now_mb() -> Option<f64> {
    status_mb("VmRSS:")
}

/// Lets the peak begin anew at what is held now; none where the system cannot.
pub(crate) fn forget_peak() -> Option<()> {
    std::fs::write("/proc/self/clear_refs", "5").ok()
}

fn status_mb(label: &str) -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix(label))?;
    let kilobytes: f64 = line.trim().trim_end_matches("kB").trim().parse().ok()?;
    Some((kilobytes / 102.4).round() / 10.0)
}
