use crate::Format;
use crate::ply::{self, PlyModel};
use crate::undistort::undistorted;
use crate::view::View;
use nextview::geometry::Plane;
use nextview::sensor::Intrinsics;
use nextview::session::ON_TABLE;
use nextview_recording::{ReadOptions, RecordedFrame, Recording};
use nextview_scan::{FRAMES_FOLDER, Fault, Faults, ScanRecord, files};
use rayon::prelude::*;
use std::path::Path;

/// What a scan left in its folder.
pub(crate) struct Scanned {
    /// Optics of all pictures, without distortion.
    pub intrinsics: Intrinsics,
    /// In the order in which they were taken.
    pub views: Vec<View>,
    /// The final cloud, metres.
    pub cloud: PlyModel,
    /// The final mesh without what belongs to the table, metres.
    pub object: PlyModel,
}

/// Largest record that is read, bytes.
const MAX_RECORD: u64 = 1 << 28;

impl Scanned {
    /// Reads the results.
    pub fn read(dir: &Path) -> Result<Self, Faults> {
        let frames = dir.join(FRAMES_FOLDER);
        if !frames.is_dir() {
            let fault = Fault::data("holds no results of a scan: there is no folder frames").in_file(dir);
            return Err(fault
                .with_remedy("scan first: `nextview scan` writes frames beside the model")
                .into());
        }
        let record = record(&dir.join("record.json"))?;
        let recording = Recording::open(&frames, &ReadOptions::default())?;
        let views = recording.frames.par_iter().map(view).collect::<Result<Vec<_>, Fault>>()?;
        let table = record.steps.last().and_then(|step| step.table());
        Ok(Self {
            intrinsics: crate::undistort::ideal(&recording.intrinsics)?,
            views,
            cloud: ply::read(&dir.join("cloud.ply"))?,
            object: above(table, ply::read(&dir.join("mesh.ply"))?),
        })
    }

    /// Fails if the form needs what the results do not have.
    pub fn check(&self, format: Format) -> Result<(), Fault> {
        let uncolored = self.views.iter().find(|view| view.color.is_none());
        if let Some(view) = uncolored.filter(|_| format.needs_color()) {
            let message =
                format!("frame {} has no colour image, and {format} is of no use without", view.number);
            return Err(Fault::data(message).with_remedy("scan with colour images beside the depth"));
        }
        if self.object.triangles.is_empty() && format.needs_mesh() {
            return Err(Fault::data("the mesh has no triangle above the table, so that there is no object"));
        }
        Ok(())
    }
}

fn record(path: &Path) -> Result<ScanRecord, Fault> {
    let text = files::read_text(path, MAX_RECORD)?;
    serde_json::from_str(&text).map_err(|error| Fault::data(error).in_file(path))
}

fn view(recorded: &RecordedFrame) -> Result<View, Fault> {
    let number = recorded.name.strip_prefix("frame ").and_then(|number| number.parse().ok());
    let number = number.ok_or_else(|| Fault::data(format!("{} has no number", recorded.name)))?;
    let (frame, color) = undistorted(recorded.load()?, recorded.load_color()?)?;
    Ok(View { number, frame, color })
}

/// The part of a mesh that is not the table, without vertices that nothing refers to.
fn above(table: Option<Plane>, mesh: PlyModel) -> PlyModel {
    let is_above = |i: u32| table.is_none_or(|t| t.height(mesh.points[i as usize].position) > ON_TABLE);
    let triangles: Vec<[u32; 3]> =
        mesh.triangles.iter().filter(|triangle| triangle.iter().all(|&i| is_above(i))).copied().collect();
    let mut new_index = vec![None; mesh.points.len()];
    let mut points = Vec::new();
    let mut renumbered = |i: u32| {
        *new_index[i as usize].get_or_insert_with(|| {
            points.push(mesh.points[i as usize]);
            points.len() as u32 - 1
        })
    };
    let triangles = triangles.into_iter().map(|triangle| triangle.map(&mut renumbered)).collect();
    PlyModel { points, triangles }
}
