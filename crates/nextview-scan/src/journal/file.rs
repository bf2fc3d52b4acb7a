use super::entry::Entry;
use super::kept::{JournalEntry, KeptFrame, SkippedView};
use super::read::{self, MAGIC};
use crate::Fault;
use crate::files::{self, Whereabouts, name_new, sync_folder, unfinished, whereabouts};
use std::fmt;
use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::{self, BufReader, ErrorKind, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::thread;
use std::time::Duration;

/// The file in which a scan keeps its frames, each before it counts.
///
/// A frame that was [kept](Self::keep) is on the disk, whatever happens to the program or the machine then,
/// in the file that the journal's path leads to: if that file was removed, moved or replaced, or its folder
/// was, no frame is kept until it is back. The file begins with a text of the scan's own, such as its
/// configuration. Every entry has a checksum: damage is found, and everything before it can be used.
///
/// ```
/// use glam::DVec2;
/// use nextview::geometry::Pose;
/// use nextview::sensor::{DepthImage, Frame, Intrinsics};
/// use nextview_scan::{Journal, JournalEntry, KeptFrame};
///
/// let path = std::env::temp_dir().join(format!("nextview-doc-{}.journal", std::process::id()));
/// let camera = Intrinsics::pinhole(4, 2, DVec2::splat(3.0), DVec2::new(1.5, 0.5)).unwrap();
/// let image = DepthImage::from_metres(4, 2, vec![0.5; 8]).unwrap();
/// let frame = Frame::new(image, camera, Pose::IDENTITY, 1.0).unwrap();
///
/// let mut journal = Journal::create(&path, "planner = \"local\"")?; journal.keep(&KeptFrame { view: Some(7),
/// was_asked: true, frame: frame.clone(), color: None, name: None })?; drop(journal); // or kill -9
///
/// let (mut journal, found) = Journal::open(&path)?;
/// assert_eq!(found.heading, "planner = \"local\"");
/// assert!(matches!(&found.entries[0], JournalEntry::Frame(kept) if kept.view == Some(7)));
/// journal.keep(&KeptFrame { view: Some(3), was_asked: true, frame, color: None, name: None })?; // and on
/// # std::fs::remove_file(&path).unwrap();
/// # Ok::<(), nextview_scan::Fault>(())
/// ```
#[derive(Debug)]
pub struct Journal {
    /// As it was given.
    path: PathBuf,
    /// The same from the root: the working directory may change.
    place: PathBuf,
    file: File,
    /// Number of entries, the heading's included.
    n_entries: u64,
    /// Where the next one begins.
    end: u64,
}

/// Largest journal without entries: a configuration may have a megabyte.
const MAX_BARE: u64 = 1 << 22;

/// The content of a journal.
#[derive(Debug)]
pub struct Kept {
    /// The text it was begun with.
    pub heading: String,
    /// Frames and skipped views, oldest first.
    pub entries: Vec<JournalEntry>,
    /// The damage behind the last of them, which was moved to a file of its own; none if the journal was
    /// whole.
    pub damage: Option<Damage>,
}

/// Bytes at the end of a journal that could not be read.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Damage {
    /// Where it begins, in bytes.
    pub at: u64,
    /// Its length, in bytes.
    pub length: u64,
    /// The fault there.
    pub problem: String,
    /// Where these bytes are now.
    pub moved_to: PathBuf,
}

impl fmt::Display for Damage {
    /// Without the path of the journal.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { at, length, problem, moved_to } = self;
        let moved_to = moved_to.display();
        write!(f, "damaged from byte {at} on ({problem}); these {length} bytes are now in {moved_to}")
    }
}

impl Journal {
    /// Begins a journal. It appears as a whole; fails if there is one already.
    pub fn create(path: &Path, heading: &str) -> Result<Self, Fault> {
        if path.exists() {
            return Err(Fault::data("exists already").in_file(path));
        }
        Self::begin(path, heading).map_err(|error| Fault::from(error).while_writing(path))
    }

    /// Opens the journal of a scan that was interrupted, to resume it. Damage at its end is moved to a file
    /// beside it; fails if not even the heading is whole, or if it is open already.
    pub fn open(path: &Path) -> Result<(Self, Kept), Fault> {
        Self::reopen(path).map_err(|fault| fault.in_file(path))
    }

    /// Keeps a frame: when this returns, it is on the disk. After a failure, such as a full disk or a folder
    /// that was moved, the journal is as it was before.
    pub fn keep(&mut self, kept: &KeptFrame) -> Result<(), Fault> {
        self.add(&Entry::Frame(kept))
    }

    /// Keeps that a view is not to be proposed again, in the same way.
    pub fn skip(&mut self, skipped: &SkippedView) -> Result<(), Fault> {
        self.add(&Entry::Skip(skipped))
    }

    /// Whether somebody has the journal there open.
    pub(super) fn is_open(path: &Path) -> bool {
        let is_locked =
            |file: BufReader<File>| matches!(file.get_ref().try_lock_shared(), Err(TryLockError::WouldBlock));
        files::open(path).is_ok_and(is_locked)
    }

    /// Whether there is a whole journal that holds nothing but its heading.
    pub(super) fn is_bare(path: &Path) -> bool {
        let found = files::read(path, MAX_BARE).and_then(|bytes| read::read(&bytes));
        found.is_ok_and(|found| found.entries.is_empty() && found.problem.is_none())
    }

    /// Its path from the root.
    pub(super) fn place(&self) -> &Path {
        &self.place
    }

    /// What the path of the journal leads to now.
    pub(super) fn whereabouts(&self) -> io::Result<Whereabouts> {
        whereabouts(&self.place, &self.file)
    }

    /// Fails if the path of the journal leads to it no longer: what is written to it would not be found.
    pub(super) fn check(&self) -> Result<(), Fault> {
        let found = self.whereabouts().map_err(|error| Fault::from(error).in_file(&self.path))?;
        let (problem, remedy) = match found {
            Whereabouts::There => return Ok(()),
            Whereabouts::Replaced => ("it was replaced by another file", "put the journal of this scan back"),
            Whereabouts::Moved => ("it was moved, or its folder was", "move it back"),
            Whereabouts::Removed => {
                ("it was removed, with all frames in it", "begin the scan again, and leave its folder alone")
            }
        };
        let fault = Fault::data(format!("{problem}, while the scan was under way")).in_file(&self.path);
        Err(fault.with_remedy(remedy))
    }

    fn add(&mut self, entry: &Entry<'_>) -> Result<(), Fault> {
        let framed = read::framed(self.n_entries, &entry.to_bytes());
        let written = self.append(&framed).map_err(|error| {
            let is_limited = error.kind() == ErrorKind::FileTooLarge;
            let fault = Fault::from(error).while_writing(&self.path);
            fault.with_remedy(match is_limited {
                true => "is there a limit to the size of files (ulimit -f)?",
                false => "is the disk full?",
            })
        });
        // Last: what is on the disk then can be found there.
        if let Err(fault) = written.and_then(|()| self.check()) {
            // A part that was written is not whole, and would be taken for damage.
            let _ = self.file.set_len(self.end);
            return Err(fault);
        }
        self.n_entries += 1;
        self.end += framed.len() as u64;
        Ok(())
    }

    fn begin(path: &Path, heading: &str) -> io::Result<Self> {
        let place = std::path::absolute(path)?;
        let beside = place.with_file_name(unfinished(&place));
        let file = OpenOptions::new().read(true).write(true).create_new(true).open(&beside)?;
        let mut journal = Self { path: path.to_owned(), place, file, n_entries: 0, end: 0 };
        let begun = journal.write_heading(heading).and_then(|()| name_new(&beside, &journal.place));
        begun.inspect_err(|_| _ = fs::remove_file(&beside))?;
        Ok(journal)
    }

    fn write_heading(&mut self, heading: &str) -> io::Result<()> {
        self.lock()?;
        self.file.write_all(MAGIC)?;
        self.end = MAGIC.len() as u64;
        let framed = read::framed(0, &Entry::Heading(heading).to_bytes());
        self.append(&framed)?;
        self.n_entries = 1;
        self.end += framed.len() as u64;
        Ok(())
    }

    fn append(&mut self, framed: &[u8]) -> io::Result<()> {
        self.file.seek(SeekFrom::Start(self.end))?;
        self.file.write_all(framed)?;
        self.file.sync_data()
    }

    fn reopen(path: &Path) -> Result<(Self, Kept), Fault> {
        let file = OpenOptions::new().read(true).write(true).open(path)?;
        if !file.metadata()?.is_file() {
            return Err(Fault::data("is not a regular file"));
        }
        let place = std::path::absolute(path)?;
        let mut journal = Self { path: path.to_owned(), place, file, n_entries: 0, end: 0 };
        journal.lock()?;
        // Whoever had the lock before may have removed it.
        journal.check()?;
        let mut bytes = Vec::new();
        journal.file.read_to_end(&mut bytes)?;
        let found = read::read(&bytes)?;
        (journal.n_entries, journal.end) = (1 + found.entries.len() as u64, found.end as u64);
        let damage = found.problem.map(|problem| journal.cut(&bytes[found.end..], problem)).transpose()?;
        Ok((journal, Kept { heading: found.heading, entries: found.entries, damage }))
    }

    /// Moves the bytes behind the last whole entry to a file beside the journal.
    fn cut(&mut self, bytes: &[u8], problem: String) -> io::Result<Damage> {
        let moved_to = free_name(&self.path);
        let mut file = File::create_new(&moved_to)?;
        file.write_all(bytes)?;
        file.sync_all()?;
        sync_folder(&moved_to)?;
        self.file.set_len(self.end)?;
        self.file.sync_all()?;
        Ok(Damage { at: self.end, length: bytes.len() as u64, problem, moved_to })
    }

    fn lock(&self) -> io::Result<()> {
        // Whoever looks whether it is open holds the lock for an instant.
        for _ in 0..20 {
            match self.file.try_lock() {
                Err(TryLockError::WouldBlock) => thread::sleep(Duration::from_millis(2)),
                // Some file systems have no locks.
                Err(TryLockError::Error(error)) if error.kind() == ErrorKind::Unsupported => return Ok(()),
                Err(TryLockError::Error(error)) => return Err(error),
                Ok(()) => return Ok(()),
            }
        }
        Err(io::Error::other("it is open already, here or in another process"))
    }
}

/// The first of `journal.damaged-1`, `journal.damaged-2`, ... that is not there.
fn free_name(path: &Path) -> PathBuf {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let mut names = (1..).map(|i| path.with_file_name(format!("{name}.damaged-{i}")));
    names.find(|name| !name.exists()).expect("no folder holds all of them")
}
