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
    /// Number of the view that it was taken for; none if it was no candidate.
    pub view: Option<usize>,
    /// Whether it answers a proposed view, rather than being pushed without one.
    pub was_asked: bool,
    /// The frame, to the bit.
    pub frame: Frame,
    /// The colours that were pushed with it.
    pub color: Option<ColorImage>,
    /// The name given by the client that took it.
    pub name: Option<String>,
}

/// A view that is not to be proposed again.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SkippedView {
    /// Its number.
    pub view: usize,
    /// The reason, in the words of the client that skipped it.
    pub reason: String,
    /// Whether a view had been decided on when it was skipped. A resumed scan decides in the same order,
    /// since planners may remember their decisions.
    pub was_decided: bool,
}
