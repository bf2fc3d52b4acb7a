//! The status of the node, as JSON.

use crate::messages::Text;
use crate::scan::State;
use serde::Serialize;
use std::collections::BTreeMap;

#[derive(Serialize)]
struct Status<'a> {
    #[serde(flatten)]
    scan: &'a State,
    /// Number of active and waiting orders: while there are any, the next view is not yet known.
    busy: usize,
    /// Whether an image is awaited.
    capturing: bool,
    /// Number of images received since the node started.
    images: u64,
    /// The current problems, by subject.
    problems: BTreeMap<&'static str, &'a str>,
}

/// The status as a message.
pub fn message(
    scan: &State,
    busy: usize,
    capturing: bool,
    images: u64,
    problems: BTreeMap<&'static str, &str>,
) -> Text {
    let status = Status { scan, busy, capturing, images, problems };
    // Only maps with non-text keys could fail.
    Text { data: serde_json::to_string(&status).unwrap_or_default() }
}
