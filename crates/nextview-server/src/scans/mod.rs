//! All scans of a server, on the disk and in memory, with one request at a time for each.

mod about;
mod creation;
mod events;
mod folder;
pub(crate) mod kept_page;
mod registry;
mod scan;
mod summary;
mod work;

pub(crate) use creation::NewScan;
pub(crate) use events::{EventStream, Told};
pub(crate) use folder::ScansFolder;
pub(crate) use kept_page::Picture;
pub(crate) use registry::Scans;
pub(crate) use scan::{PageContent, Scan};
pub(crate) use summary::{ScanPhase, ScanSummary};
pub(crate) use work::Work;
