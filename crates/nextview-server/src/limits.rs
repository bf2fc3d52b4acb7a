use nextview_scan::Fault;
use std::time::Duration;

/// Limits of a server. Requests beyond a limit are refused with an answer that names it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// Size of a request's body in bytes. Default 64 MiB: depth of 16 megapixels as 32-bit numbers.
    pub body_bytes: usize,
    /// Total size, in bytes, of bodies being received or processed. Default 256 MiB.
    pub all_bodies_bytes: usize,
    /// Number of pixels of a camera's images. Default 8 million.
    pub image_pixels: usize,
    /// Number of unfinished scans. Default 64.
    pub scans: usize,
    /// Number of frames of a scan. Default 500.
    pub frames: usize,
    /// Number of view candidates of a scan. Default 20,000.
    pub candidates: usize,
    /// Number of simultaneous connections. Default 256.
    pub connections: usize,
    /// Number of connections that listen to events. Default 64.
    pub event_streams: usize,
    /// Number of pending requests to one scan. Default 16.
    pub queue: usize,
    /// Memory of the process in MB above which neither scans nor frames are accepted. Default 4096.
    pub memory_mb: u64,
    /// Disk space to keep free in MB. Default 512.
    pub free_disk_mb: u64,
    /// Time for the head of a request, including idle time before it. Default 10 s.
    pub head_time: Duration,
    /// Time for the body of a request, and for the client to accept part of an answer. Default 30 s.
    pub body_time: Duration,
    /// Time for an answer; the work continues after it. Default 120 s.
    pub answer_time: Duration,
}

impl Default for Limits {
    fn default() -> Self {
        Self {
            body_bytes: 64 << 20,
            all_bodies_bytes: 256 << 20,
            image_pixels: 8_000_000,
            scans: 64,
            frames: 500,
            candidates: 20_000,
            connections: 256,
            event_streams: 64,
            queue: 16,
            memory_mb: 4096,
            free_disk_mb: 512,
            head_time: Duration::from_secs(10),
            body_time: Duration::from_secs(30),
            answer_time: Duration::from_secs(120),
        }
    }
}

/// The fault of exceeding a limit: the actual and the maximum value.
pub(crate) fn exceeded(what: &str, value: impl ToString, most: impl ToString) -> Fault {
    Fault::of_value(what, value.to_string(), format!("at most {}", most.to_string()))
}
