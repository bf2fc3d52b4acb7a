use crate::results::FRAMES_FOLDER;
use crate::{Fault, ScanRecord};
use glam::DVec3;
use nextview::Cancel;
use nextview::geometry::Aabb;
use nextview::placement::ShownObject;
use nextview::sensor::{ColorImage, Frame};
use nextview::session::shown_object;
use nextview_recording::{ReadOptions, RecordedFrame, Recording};
use std::path::Path;

const RESTORE: &str = "put the files of that scan back, or scan the object again";

/// A finished scan of an object that has been turned since.
pub(crate) struct EarlierScan {
    /// The object as that scan showed it.
    pub shown: ShownObject,
    frames: Vec<RecordedFrame>,
}

impl EarlierScan {
    /// Reads the results in a folder; fails if they are not those of one placement on a table.
    pub fn open(dir: &Path, cancel: &Cancel) -> Result<Self, Fault> {
        let record = ScanRecord::read(dir)?;
        let fault = |problem: &str, remedy: &str| Fault::data(problem).in_file(dir).with_remedy(remedy);
        if record.turn.is_some() {
            return Err(fault(
                "holds a scan that went on after another one: nothing can go on after both",
                "`after` names the results of a scan that was the first of its object",
            ));
        }
        let Recording { frames, skipped, .. } =
            Recording::open(&dir.join(FRAMES_FOLDER), &ReadOptions::default())?;
        // All that a scan leaves fits together; what was changed since would give another object.
        if let Some(skipped) = skipped.first() {
            let fault =
                Fault::data(format!("a frame cannot be read: {skipped}")).in_file(&dir.join(FRAMES_FOLDER));
            return Err(fault.with_remedy(RESTORE));
        }
        if frames.len() > record.steps.len() {
            let (n, n_steps) = (frames.len(), record.steps.len());
            let problem =
                format!("holds {n} frames, but record.json is of {n_steps}: they are not of one scan");
            return Err(fault(&problem, RESTORE));
        }
        let Some(table) = record.table() else {
            return Err(fault(
                "holds a scan without a table, so the side on which the object stood is unknown",
                "scan an object that is to be turned with `object_box.table` = fit or known",
            ));
        };
        let (Some(min), Some(max)) = (record.box_min_m, record.box_max_m) else {
            return Err(fault("holds a scan that found no object", "scan the object again"));
        };
        let bounds = Aabb { min: DVec3::from_array(min), max: DVec3::from_array(max) };
        let loaded: Vec<Frame> = frames.iter().map(RecordedFrame::load).collect::<Result<_, _>>()?;
        let shown = shown_object(&loaded, bounds, table, record.voxel_size_m, cancel)?;
        Ok(Self { shown, frames })
    }

    /// The colours of a frame, by its index.
    pub fn color(&self, i: usize) -> Result<Option<ColorImage>, Fault> {
        Ok(self.frames[i].load_color()?)
    }
}
