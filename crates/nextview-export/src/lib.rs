//! Results of a scan in formats for other tools.
//!
//! [`export`] reads a scan's result folder (frames, cloud, mesh, record) and writes a separate folder. All
//! formats hold the same pictures: those of the frames in the map, without lens distortion, at their mapped
//! poses. `docs/export.md` lists the files, axes and units of each.

mod format;
mod formats;
mod masks;
mod scanned;
mod textured;
mod undistort;
mod view;

pub use format::Format;
pub use formats::NamedFile;

use nextview_scan::files::{Overwrite, ResultFolder};
use nextview_scan::{Fault, Faults};
use scanned::Scanned;
use std::io::Write;
use std::path::Path;

/// The result of an export.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Exported {
    /// Number of pictures.
    pub n_views: usize,
    /// Remarks for the user, such as omissions.
    pub notes: Vec<String>,
}

/// Writes the results in the folder `results` into the folder `out`, which appears as a whole or not at all.
///
/// # Errors
/// If `results` holds no frames, or one of its files is damaged; if the format needs colours and a frame has
/// none; if `out` holds files with the same names and the rule forbids replacing them, or if it is the folder
/// of the results.
pub fn export(results: &Path, format: Format, out: &Path, rule: Overwrite) -> Result<Exported, Faults> {
    let is_same = || Some(results.canonicalize().ok()? == out.canonicalize().ok()?);
    if is_same() == Some(true) {
        let fault = Fault::request("is the folder of the results").in_file(out);
        return Err(fault.with_remedy("choose another folder (`out`)").into());
    }
    let mut folder = ResultFolder::begin(out, format.entries(), rule)?;
    let (files, exported) = export_files(results, format)?;
    for (name, bytes) in files {
        folder.add(name, |w| Ok(w.write_all(&bytes)?))?;
    }
    folder.publish()?;
    Ok(exported)
}

/// Returns the files of an export without writing them.
///
/// # Errors
/// Those of [`export`], except the ones about the folder `out`.
pub fn export_files(results: &Path, format: Format) -> Result<(Vec<NamedFile>, Exported), Faults> {
    let scanned = Scanned::read(results)?;
    scanned.check(format)?;
    let files = formats::files(format, &scanned)?;
    let n_views = scanned.views.len();
    let notes = match scanned.views.iter().filter(|view| view.color.is_none()).count() {
        n if n == 0 || !format.has_views() => Vec::new(),
        n if n == n_views => vec!["the frames have no colour images".to_owned()],
        n => vec![format!("{n} of {n_views} frames have no colour image")],
    };
    Ok((files, Exported { n_views, notes }))
}
