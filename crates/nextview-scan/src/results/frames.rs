use super::frames_folder::FRAMES_FOLDER;
use crate::files::ResultFolder;
use crate::run::{ModelFrames, ScanState};
use crate::{Fault, Faults};
use nextview_recording::{NumberedFrame, write_folder};
use std::io::Write;
use std::path::Path;

/// The files that the folder may hold.
const CONTENT: [&str; 5] = ["intrinsics.txt", "poses.csv", "depth", "mask", "color"];

/// Fails if replacing the folder would remove files that no scan has left there.
pub(super) fn check_replaceable(dir: &Path) -> Result<(), Faults> {
    let folder = dir.join(FRAMES_FOLDER);
    if !folder.is_dir() {
        return Ok(());
    }
    let entries = std::fs::read_dir(&folder).map_err(|error| Fault::from(error).in_file(&folder))?;
    let names = entries.flatten().map(|entry| entry.file_name().to_string_lossy().into_owned());
    match names.into_iter().find(|name| !CONTENT.contains(&name.as_str())) {
        None => Ok(()),
        Some(name) => {
            let fault = Fault::data(format!("holds {name}, which a scan would remove")).in_file(&folder);
            Err(fault.with_remedy("choose another folder (`out`)").into())
        }
    }
}

/// Adds the frames of the map. A frame with unavailable colours is added without them, and the fault is
/// reported.
pub(super) fn add(folder: &mut ResultFolder, scan: &ScanState<'_>) -> Result<(), Fault> {
    let ModelFrames { frames, n_earlier } = scan.model_frames()?;
    let steps = scan.session.frame_numbers();
    let numbers =
        (0..n_earlier).map(|i| scan.steps.len() + 1 + i).chain(steps.iter().map(|step_idx| step_idx + 1));
    let frames: Vec<NumberedFrame<'_>> =
        numbers.zip(frames.iter()).map(|(number, frame)| NumberedFrame { number, frame }).collect();
    let write = |name: &str, bytes: Vec<u8>| {
        folder.add(format!("{FRAMES_FOLDER}/{name}"), |w| Ok(w.write_all(&bytes)?))
    };
    let mut fault = None;
    let color = |i: usize| {
        Ok(scan.model_color(i, n_earlier).unwrap_or_else(|problem| {
            fault.get_or_insert(problem);
            None
        }))
    };
    write_folder(&frames, color, write)?;
    fault.map_or(Ok(()), Err)
}
