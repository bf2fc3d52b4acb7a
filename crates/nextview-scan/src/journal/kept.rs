use nextview::sensor::{ColorImage, Frame};
use serde::{Deserialize, Serialize};

/// An entry of a journal.
#[derive(Clone, Debug)]
pub enum JournalEntry {
    /// A frame was taken.
    Frame(Box<KeptFrame>),
    /// A view was skipped.
    Skip(SkippedView),
}

/// A frame of a journal.
#[derive(Clone, Debug)]
pub struct KeptFrame {
    /// Number of the view it was taken for; `None` if that was no candidate.
    pub view: Option<usize>,
    /// Whether it answers a proposed view; otherwise it was pushed without one.
    pub was_asked: bool,
    /// The frame, bit for bit.
    pub frame: Frame,
    /// The colours pushed with it.
    pub color: Option<ColorImage>,
    /// The name given by the client that took it.
    pub name: Option<String>,
}

/// A view that must not be proposed again.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SkippedView {
    /// Number of the view.
    pub view: usize,
    /// The reason, in the words of the client that skipped it.
    pub reason: String,
    /// Whether a view had been decided on when it was skipped. A resumed scan decides in the same order,
    /// because planners may remember their decisions.
    pub was_decided: bool,
}
