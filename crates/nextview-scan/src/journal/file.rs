use super::entry::Entry;
use super::kept::{JournalEntry, KeptFrame, SkippedView};
use super::read::{self, MAGIC};
use crate::Fault;
use crate::files::{self, PathTarget, name_new, path_target, sync_folder, unfinished};
use std::fmt;
use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::{self, BufReader, ErrorKind, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::thread;
use std::time::Duration;

/// The file that stores the frames of a scan, each before it counts.
///
/// A frame that was [kept](Self::keep) is on the disk, whatever happens to the program or the machine, in the
/// file at the journal's path. If that file or its folder was removed, moved or replaced, no frame is kept
/// until it is back. The file begins with the scan's own text, such as its configuration. Every entry has a
/// checksum: damage is detected, and everything before it remains usable.
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
    /// The path as given.
    path: PathBuf,
    /// The absolute path: the working directory may change.
    place: PathBuf,
    file: File,
    /// Number of entries, including the heading.
    n_entries: u64,
    /// Where the next entry begins.
    end: u64,
}

/// Maximum size of a journal without entries: a configuration may have a megabyte.
const MAX_BARE: u64 = 1 << 22;

/// The content of a journal.
#[derive(Debug)]
pub struct Kept {
    /// The text at its beginning.
    pub heading: String,
    /// Frames and skipped views, oldest first.
    pub entries: Vec<JournalEntry>,
    /// The damage after the last entry, moved to a separate file; `None` if the journal was undamaged.
    pub damage: Option<Damage>,
}

/// Bytes at the end of a journal that could not be read.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Damage {
    /// Offset of the damage in bytes.
    pub at: u64,
    /// Length of the damage in bytes.
    pub length: u64,
    /// The fault at that offset.
    pub problem: String,
    /// Where these bytes are now.
    pub moved_to: PathBuf,
}

impl fmt::Display for Damage {
    /// Omits the path of the journal.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { at, length, problem, moved_to } = self;
        let moved_to = moved_to.display();
        write!(f, "damaged from byte {at} ({problem}); the {length} bytes from there are now in {moved_to}")
    }
}

impl Journal {
    /// Creates a journal, which appears as a whole or not at all. Fails if the file exists.
    pub fn create(path: &Path, heading: &str) -> Result<Self, Fault> {
        if path.exists() {
            return Err(Fault::data("already exists").in_file(path));
        }
        Self::begin(path, heading).map_err(|error| Fault::from(error).while_writing(path))
    }

    /// Opens the journal of an interrupted scan to resume it. Damage at its end is moved to a file next to
    /// it. Fails if even the heading is damaged, or if the journal is already open.
    pub fn open(path: &Path) -> Result<(Self, Kept), Fault> {
        Self::reopen(path).map_err(|fault| fault.in_file(path))
    }

    /// Keeps a frame: it is on the disk on return. A failure, such as a full disk or a moved folder, leaves
    /// the journal as it was.
    pub fn keep(&mut self, kept: &KeptFrame) -> Result<(), Fault> {
        self.add(&Entry::Frame(kept))
    }

    /// Keeps a skipped view in the same way.
    pub fn skip(&mut self, skipped: &SkippedView) -> Result<(), Fault> {
        self.add(&Entry::Skip(skipped))
    }

    /// Whether any process has this journal open.
    pub(super) fn is_open(path: &Path) -> bool {
        let is_locked =
            |file: BufReader<File>| matches!(file.get_ref().try_lock_shared(), Err(TryLockError::WouldBlock));
        files::open(path).is_ok_and(is_locked)
    }

    /// Whether there is an undamaged journal that contains only its heading.
    pub(super) fn is_bare(path: &Path) -> bool {
        let found = files::read(path, MAX_BARE).and_then(|bytes| read::read(&bytes));
        found.is_ok_and(|found| found.entries.is_empty() && found.problem.is_none())
    }

    /// Absolute path of the journal.
    pub(super) fn place(&self) -> &Path {
        &self.place
    }

    /// What the path of the journal leads to now.
    pub(super) fn path_target(&self) -> io::Result<PathTarget> {
        path_target(&self.place, &self.file)
    }

    /// Fails if the path of the journal no longer leads to it: anything written to it would not be found.
    pub(super) fn check(&self) -> Result<(), Fault> {
        let found = self.path_target().map_err(|error| Fault::from(error).in_file(&self.path))?;
        let (problem, remedy) = match found {
            PathTarget::There => return Ok(()),
            PathTarget::Replaced => ("it was replaced by another file", "restore the journal of this scan"),
            PathTarget::Moved => ("it was moved, or its folder was", "move it back"),
            PathTarget::Removed => (
                "it was removed, with all frames in it",
                "start the scan again, and do not change its folder",
            ),
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
        // Checked last, to ensure that everything on the disk can be found there.
        if let Err(fault) = written.and_then(|()| self.check()) {
            // A partly written entry would be taken for damage.
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
        // The previous owner of the lock may have removed it.
        journal.check()?;
        let mut bytes = Vec::new();
        journal.file.read_to_end(&mut bytes)?;
        let found = read::read(&bytes)?;
        (journal.n_entries, journal.end) = (1 + found.entries.len() as u64, found.end as u64);
        let damage = found.problem.map(|problem| journal.cut(&bytes[found.end..], problem)).transpose()?;
        Ok((journal, Kept { heading: found.heading, entries: found.entries, damage }))
    }

    /// Moves the bytes after the last undamaged entry to a file next to the journal.
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
        // A check whether the journal is open holds the lock for an instant.
        for _ in 0..20 {
            match self.file.try_lock() {
                Err(TryLockError::WouldBlock) => thread::sleep(Duration::from_millis(2)),
                // Some file systems have no locks.
                Err(TryLockError::Error(error)) if error.kind() == ErrorKind::Unsupported => return Ok(()),
                Err(TryLockError::Error(error)) => return Err(error),
                Ok(()) => return Ok(()),
            }
        }
        Err(io::Error::other("it is already open, here or in another process"))
    }
}

/// The first free name of `journal.damaged-1`, `journal.damaged-2` and so on.
fn free_name(path: &Path) -> PathBuf {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let mut names = (1..).map(|i| path.with_file_name(format!("{name}.damaged-{i}")));
    names.find(|name| !name.exists()).expect("no folder holds all of them")
}
