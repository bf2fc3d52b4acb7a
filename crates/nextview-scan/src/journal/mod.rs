//! The journal of a scan in progress: its frames are on the disk before they count.

mod entry;
mod file;
#[cfg(fuzzing)]
pub mod fuzzing;
mod kept;
mod read;
mod scan_journal;

pub use file::{Damage, Journal, Kept};
pub use kept::{JournalEntry, KeptFrame, SkippedView};
pub(crate) use scan_journal::Occupant;
pub use scan_journal::{Interrupted, ScanJournal};
