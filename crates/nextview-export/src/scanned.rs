use crate::Format;
use crate::undistort::undistorted;
use crate::view::UndistortedView;
use nextview::sensor::Intrinsics;
use nextview_recording::{ReadOptions, RecordedFrame, Recording};
use nextview_scan::{FRAMES_FOLDER, Fault, Faults, SavedModel, ScanRecord};
use rayon::prelude::*;
use std::path::Path;

/// The results of a scan in its folder.
pub(crate) struct Scanned {
    /// Optics of all pictures, without distortion.
    pub intrinsics: Intrinsics,
    /// Pictures in order of capture.
    pub views: Vec<UndistortedView>,
    /// The final cloud, metres.
    pub cloud: SavedModel,
    /// The final mesh without the table, metres.
    pub object: SavedModel,
}

impl Scanned {
    /// Reads the results.
    pub fn read(dir: &Path) -> Result<Self, Faults> {
        let table = ScanRecord::read(dir)?.table();
        let frames = dir.join(FRAMES_FOLDER);
        if !frames.is_dir() {
            let fault = Fault::data("holds no frames of the scan: the folder frames is missing").in_file(dir);
            return Err(fault.with_remedy("scan again: a scan saves its frames there").into());
        }
        let recording = Recording::open(&frames, &ReadOptions::default())?;
        let views = recording.frames.par_iter().map(view).collect::<Result<Vec<_>, Fault>>()?;
        Ok(Self {
            intrinsics: crate::undistort::ideal(&recording.intrinsics)?,
            views,
            cloud: SavedModel::read(&dir.join("cloud.ply"))?,
            object: SavedModel::read(&dir.join("mesh.ply"))?.above(table),
        })
    }

    /// Fails if the results lack data for the format.
    pub fn check(&self, format: Format) -> Result<(), Fault> {
        let uncolored = self.views.iter().find(|view| view.color.is_none());
        if let Some(view) = uncolored.filter(|_| format.needs_color()) {
            let message = format!("frame {} has no colour image, which {format} requires", view.number);
            return Err(
                Fault::data(message).with_remedy("scan with colour images in addition to depth images")
            );
        }
        if self.object.triangles.is_empty() && format.needs_mesh() {
            return Err(Fault::data("the mesh has no triangle above the table, so there is no object"));
        }
        Ok(())
    }
}

fn view(recorded: &RecordedFrame) -> Result<UndistortedView, Fault> {
    let number = recorded.name.strip_prefix("frame ").and_then(|number| number.parse().ok());
    let number = number.ok_or_else(|| Fault::data(format!("{} has no number", recorded.name)))?;
    let (frame, color) = undistorted(recorded.load()?, recorded.load_color()?)?;
    Ok(UndistortedView { number, frame, color })
}
