//! Texts and messages without files, for `fuzz/` only.

pub use crate::mcap::fuzzing::{chunk, messages};

use crate::{ReadOptions, folder, lens, rigid, tum};

/// Reads a text as each file format of recordings.
pub fn texts(text: &str) {
    let _ = lens::parse(text, 0.001);
    let _ = tum::entries(text, tum::pose);
    let _ = tum::entries(text, tum::image);
    let _ = rigid::parse_transform(text);
    let _ = folder::rows(text, &ReadOptions::default());
}
