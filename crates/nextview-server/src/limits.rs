use nextview_scan::Fault;
use std::time::Duration;

/// How much a server takes on. What is more is refused with an answer that says which limit it was.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// Bytes of a request's body. Default 64 MiB: depth of 16 megapixels as 32-bit numbers.
    pub body_bytes: usize,
    /// Bytes of all bodies that are being received or worked on. Default 256 MiB.
    pub all_bodies_bytes: usize,
    /// Pixels of a camera's images. Default 8 million.
    pub image_pixels: usize,
    /// Scans that are under way. Default 64.
    pub scans: usize,
    /// Frames of a scan. Default 500.
    pub frames: usize,
    /// View candidates of a scan. Default 20,000.
    pub candidates: usize,
    /// Connections at once. Default 256.
    pub connections: usize,
    /// Connections among them that listen to events. Default 64.
    pub event_streams: usize,
    /// Requests to one scan that wait or are worked on. Default 16.
    pub queue: usize,
    /// Memory of the process, MB, above which neither scans nor frames are taken. Default 4096.
    pub memory_mb: u64,
    /// Space that stays free on the disk, MB. Default 512.
    pub free_disk_mb: u64,
    /// Time for the head of a request, also between two requests of a connection. Default 10 s.
    pub head_time: Duration,
    /// Time for the body of a request, and for the client to take a part of an answer. Default 30 s.
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

/// A limit is reached: what there is of it, and how much there may be.
pub(crate) fn exceeded(what: &str, value: impl ToString, most: impl ToString) -> Fault {
    Fault::of_value(what, value.to_string(), format!("at most {}", most.to_string()))
}
