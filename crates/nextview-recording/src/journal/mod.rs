//! The frames of a scan that is under way, safe on the disk.

mod entry;
mod scan;

use crate::RecordingError;
use entry::Entry;
use nextview::sensor::Frame;
use std::fs::{File, OpenOptions, TryLockError};
use std::io::{ErrorKind, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

/// The file in which a scan keeps its frames, each before it counts.
///
/// A frame that was [kept](Self::keep) is on the disk, whatever happens to the program or the machine then. The file begins
/// with a text of the scan's own, such as its configuration, and every part of it has a checksum: what is damaged is found
/// out, and all before it can be used.
///
/// ```
/// use glam::DVec2;
/// use nextview::geometry::Pose;
/// use nextview::sensor::{DepthImage, Frame, Intrinsics};
/// use nextview_recording::Journal;
///
/// let path = std::env::temp_dir().join(format!("nextview-doc-{}.journal", std::process::id()));
/// let camera = Intrinsics::pinhole(4, 2, DVec2::splat(3.0), DVec2::new(1.5, 0.5)).unwrap();
/// let image = DepthImage::from_metres(4, 2, vec![0.5; 8]).unwrap();
/// let frame = Frame::new(image, camera, Pose::IDENTITY, 1.0).unwrap();
///
/// let mut journal = Journal::create(&path, "planner = \"local\"")?;
/// journal.keep(Some(7), &frame)?;
/// drop(journal); // or kill -9
///
/// let (mut journal, found) = Journal::open(&path)?;
/// assert_eq!(found.heading, "planner = \"local\"");
/// assert_eq!((found.frames[0].view, found.frames[0].frame.image()), (Some(7), frame.image()));
/// journal.keep(Some(3), &frame)?; // and on
/// # std::fs::remove_file(&path).unwrap();
/// # Ok::<(), nextview_recording::RecordingError>(())
/// ```
#[derive(Debug)]
pub struct Journal {
    path: PathBuf,
    file: File,
    /// Number of entries, the heading's included.
    n_entries: u64,
    /// Where the next one begins.
    end: u64,
}

/// What a journal holds.
#[derive(Debug)]
pub struct Kept {
    /// The text it was begun with.
    pub heading: String,
    /// The frames, oldest first.
    pub frames: Vec<KeptFrame>,
    /// What was wrong behind the last of them, and has been put beside; none if the journal was whole.
    pub damage: Option<Damage>,
}

/// A frame of a journal.
#[derive(Clone, Debug)]
pub struct KeptFrame {
    /// Number of the view that it was taken for, if it has one.
    pub view: Option<usize>,
    /// The frame, to the bit.
    pub frame: Frame,
}

/// What could not be read at the end of a journal.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Damage {
    /// Where it begins, in bytes.
    pub at: u64,
    /// Its length, in bytes.
    pub length: u64,
    /// What is wrong there.
    pub problem: String,
    /// Where these bytes are now.
    pub moved_to: PathBuf,
}

const MAGIC: &[u8; 8] = b"nvframes";

impl Journal {
    /// Begins a journal. It appears as a whole; fails if there is one already.
    pub fn create(path: &Path, heading: &str) -> Result<Self, RecordingError> {
        if path.exists() {
            return Err(RecordingError::Content("exists already".into()).in_file(path));
        }
        Self::begin(path, heading).map_err(|error| RecordingError::Unwritable(error).in_file(path))
    }

    /// Opens the journal of a scan that was interrupted, to go on with it. What is damaged at its end is moved to a file beside
    /// it; fails if not even the heading is whole, or if another process has it open.
    pub fn open(path: &Path) -> Result<(Self, Kept), RecordingError> {
        Self::reopen(path).map_err(|error| error.in_file(path))
    }

    /// Keeps a frame, which was taken for this view: when this returns, it is on the disk. After a failure, such as a full disk,
    /// the journal is as it was before.
    pub fn keep(&mut self, view: Option<usize>, frame: &Frame) -> Result<(), RecordingError> {
        let payload = Entry::Frame(view, frame).to_bytes();
        self.append(&payload).map_err(|error| {
            // Whatever part was written is not whole, and would be taken for damage.
            let _ = self.file.set_len(self.end);
            RecordingError::Unwritable(error).in_file(&self.path)
        })
    }

    fn begin(path: &Path, heading: &str) -> std::io::Result<Self> {
        let mut name = path.file_name().unwrap_or_default().to_owned();
        name.push(format!(".{}.partial", std::process::id()));
        let beside = path.with_file_name(name);
        let file = OpenOptions::new().read(true).write(true).create_new(true).open(&beside)?;
        let mut journal = Self { path: path.to_owned(), file, n_entries: 0, end: 0 };
        let written = journal.write_heading(heading).and_then(|()| std::fs::rename(&beside, path));
        written.inspect_err(|_| _ = std::fs::remove_file(&beside))?;
        sync_folder(path)?;
        Ok(journal)
    }

    fn write_heading(&mut self, heading: &str) -> std::io::Result<()> {
        self.lock()?;
        self.file.write_all(MAGIC)?;
        self.end = MAGIC.len() as u64;
        self.append(&Entry::Heading(heading).to_bytes())
    }

    fn append(&mut self, payload: &[u8]) -> std::io::Result<()> {
        let framed = scan::framed(self.n_entries, payload);
        self.file.seek(SeekFrom::Start(self.end))?;
        self.file.write_all(&framed)?;
        self.file.sync_data()?;
        self.n_entries += 1;
        self.end += framed.len() as u64;
        Ok(())
    }

    fn reopen(path: &Path) -> Result<(Self, Kept), RecordingError> {
        let file = OpenOptions::new().read(true).write(true).open(path)?;
        let mut journal = Self { path: path.to_owned(), file, n_entries: 0, end: 0 };
        journal.lock()?;
        let mut bytes = Vec::new();
        journal.file.read_to_end(&mut bytes)?;
        let found = scan::read(&bytes)?;
        (journal.n_entries, journal.end) = (1 + found.frames.len() as u64, found.end as u64);
        let damage = found.problem.map(|problem| journal.cut(&bytes[found.end..], problem)).transpose()?;
        Ok((journal, Kept { heading: found.heading, frames: found.frames, damage }))
    }

    /// Moves what is behind the last whole entry to a file beside.
    fn cut(&mut self, bytes: &[u8], problem: String) -> std::io::Result<Damage> {
        let moved_to = free_name(&self.path);
        let mut file = File::create_new(&moved_to)?;
        file.write_all(bytes)?;
        file.sync_all()?;
        self.file.set_len(self.end)?;
        self.file.sync_all()?;
        Ok(Damage { at: self.end, length: bytes.len() as u64, problem, moved_to })
    }

    fn lock(&self) -> std::io::Result<()> {
        self.file.try_lock().or_else(|error| match error {
            TryLockError::WouldBlock => Err(std::io::Error::other("another process has it open")),
            // Some file systems have no locks.
            TryLockError::Error(error) if error.kind() == ErrorKind::Unsupported => Ok(()),
            TryLockError::Error(error) => Err(error),
        })
    }
}

/// The first of `journal.damaged-1`, `journal.damaged-2`, ... that is not there.
fn free_name(path: &Path) -> PathBuf {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let mut names = (1..).map(|i| path.with_file_name(format!("{name}.damaged-{i}")));
    names.find(|name| !name.exists()).expect("no folder holds all of them")
}

/// Makes sure that the folder knows of a file that was renamed in it.
fn sync_folder(path: &Path) -> std::io::Result<()> {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    // Elsewhere a folder cannot be opened, nor need it be.
    if cfg!(unix) { File::open(folder)?.sync_all() } else { Ok(()) }
}
