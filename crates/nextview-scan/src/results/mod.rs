//! The files of a scan's results.

mod frames;
mod frames_folder;
mod map_summary;
mod saved_map;
#[cfg(feature = "simulated")]
mod saved_model;

use crate::files::{Overwrite, ResultFolder, csv_field, numbered};
use crate::journal::Occupant;
use crate::run::{Measured, ScanState};
use crate::{Fault, FaultKind, Faults, ScanConfig, ScanJournal, ScanRecord, StepRecord, short_name};
use nextview::geometry::Pose;
use nextview::motion::Waypoint;
use nextview_model::{write_cloud, write_mesh};
use nextview_octomap::Octree;
use std::io::Write;
use std::path::{Path, PathBuf};

pub use frames_folder::FRAMES_FOLDER;
pub use map_summary::{MapSummary, convert_map};
pub use saved_map::SavedMap;
#[cfg(feature = "simulated")]
pub use saved_model::SavedModel;

/// The files in a folder of results.
const ENTRIES: &[&str] = &[
    "config.toml",
    "record.json",
    "steps.jsonl",
    "views.csv",
    "waypoints.csv",
    "map.ot",
    "map.bt",
    "cloud.ply",
    "mesh.ply",
    "report.html",
    FRAMES_FOLDER,
];

/// The result files of a scan: those of [`write_results`] and a page that shows them. The [`FRAMES_FOLDER`]
/// lies next to them.
pub const RESULT_FILES: &[&str] = match ENTRIES.split_last() {
    Some((_, files)) => files,
    None => &[],
};

/// Begins the folder for the results of a scan. Fails immediately if it could not be written later, if the
/// rule forbids it, or if its `frames` contains more than a scan leaves there.
pub fn begin_results(dir: &Path, rule: Overwrite) -> Result<ResultFolder, Faults> {
    frames::check_replaceable(dir)?;
    ResultFolder::begin(dir, ENTRIES, rule)
}

/// The default folder for the results of a scan: `scan-OBJECT-PLANNER`, followed by -2, -3, ... if that one
/// is being scanned, or holds results that the rule does not allow to replace. A folder with an interrupted
/// scan is not skipped, because that scan must be resumed or removed first.
pub fn result_folder(config: &ScanConfig, rule: &Overwrite) -> PathBuf {
    let is_refused = |dir: &Path| dir.is_file() || rule.check_folder(dir, ENTRIES).is_err();
    let is_taken = |dir: &Path| match ScanJournal::occupant(dir) {
        Occupant::Scan => true,
        Occupant::Interrupted => false,
        Occupant::Nobody => is_refused(dir),
    };
    numbered(&format!("scan-{}-{}", short_name(&config.object), config.planner), is_taken).1
}

/// A folder that belongs to a single scan.
pub struct ScanFolder {
    /// The path of the folder.
    pub dir: PathBuf,
    /// The configuration as stored in the journal: as a text with paths relative to the folder.
    pub heading: String,
    /// The journal for the scan's frames.
    pub journal: ScanJournal,
    /// The folder for its results.
    pub results: ResultFolder,
}

impl ScanFolder {
    /// Takes a folder before the work begins; with the journal of an interrupted scan, the folder of that
    /// scan. If nobody chose the name and another scan has taken it, takes the [next](result_folder) one.
    pub fn take(
        mut dir: PathBuf,
        may_change: bool,
        rule: &Overwrite,
        config: &ScanConfig,
        mut journal: Option<ScanJournal>,
    ) -> Result<Self, Faults> {
        loop {
            let taken = Self::take_this(&dir, rule, config, journal.take());
            let next = if may_change { result_folder(config, rule) } else { dir.clone() };
            if taken.is_ok() || next == dir {
                return taken;
            }
            dir = next;
        }
    }

    fn take_this(
        dir: &Path,
        rule: &Overwrite,
        config: &ScanConfig,
        journal: Option<ScanJournal>,
    ) -> Result<Self, Faults> {
        let heading = toml::to_string(&config.kept_in(dir)).map_err(|e| Fault::data(e.to_string()))?;
        let journal = journal.map_or_else(|| ScanJournal::begin(dir, &heading), Ok)?;
        // Last, because results may have appeared in the meantime.
        let results = begin_results(dir, rule.clone())?;
        Ok(Self { dir: dir.to_owned(), heading, journal, results })
    }
}

/// The results of a scan.
pub struct Results {
    /// The record; without measures of the model if there is none.
    pub record: ScanRecord,
    /// The faults; `None` if the results are complete.
    pub faults: Option<Faults>,
}

/// Adds all results of a scan except the pages that show it: configuration, record, poses, waypoints, map,
/// model, frames. A result that cannot be made is reported, and all others are added.
///
/// # Errors
/// If the scan is cancelled: the missing results could be made, so the folder must not be published. If the
/// folder of the scan was moved, or holds the journal of another scan.
pub fn write_results(
    folder: &mut ResultFolder,
    config: &ScanConfig,
    scan: &ScanState<'_>,
) -> Result<Results, Fault> {
    let mut faults = Vec::new();
    let model = scan.model(config.model).map_err(|fault| faults.push(fault.within("cloud and mesh"))).ok();
    let measured = model.as_ref().map_or(Measured::Nothing, Measured::Model);
    let record = scan.record(config, measured).unwrap_or_else(|fault| {
        faults.push(fault.within("bodies next to the object"));
        scan.bare_record(config)
    });
    let kept = config.kept_in(folder.target());
    let mut add = |name: &'static str, content: &dyn Fn(&mut Vec<u8>) -> Result<(), Fault>| {
        faults.extend(folder.add(name, content).err().map(|fault| fault.within(name)));
    };
    add("config.toml", &|w| Ok(w.write_all(toml::to_string(&kept).map_err(Fault::data)?.as_bytes())?));
    add("record.json", &|w| write_json(w, &record));
    add("steps.jsonl", &|w| record.steps.iter().try_for_each(|step| write_json(w, step)));
    add("views.csv", &|w| write_views(w, &record.steps));
    add("waypoints.csv", &|w| write_waypoints(w, scan));
    let octree = Octree::from_map(scan.session.map()).map(|octree| octree.pruned());
    add("map.ot", &|w| Ok(octree_of(&octree)?.write_ot(w)?));
    add("map.bt", &|w| Ok(octree_of(&octree)?.write_bt(w)?));
    if let Some(model) = &model {
        add("cloud.ply", &|w| Ok(write_cloud(w, &model.cloud)?));
        add("mesh.ply", &|w| Ok(write_mesh(w, &model.vertices, model.is_filled(), model.triangles())?));
    }
    faults.extend(frames::add(folder, scan).err().map(|fault| fault.within(FRAMES_FOLDER)));
    scan.journal.as_ref().map_or(Ok(()), ScanJournal::check_results)?;
    match faults.iter().position(|fault| fault.kind == FaultKind::Cancelled) {
        Some(cancelled) => Err(faults.swap_remove(cancelled)),
        None => Ok(Results { record, faults: Faults::of(faults) }),
    }
}

/// Returns one of the [`RESULT_FILES`] of a scan in its current state, except `report.html`. The record has
/// no measures of the model.
///
/// # Errors
/// If the scan has none of this name, or it cannot be made, such as a cloud before an object was found.
pub fn result_file(name: &str, config: &ScanConfig, scan: &ScanState<'_>) -> Result<Vec<u8>, Fault> {
    let w = &mut Vec::new();
    let octree = || Octree::from_map(scan.session.map()).map(|octree| octree.pruned());
    match name {
        "config.toml" => w.extend(toml::to_string(config).map_err(Fault::data)?.into_bytes()),
        "record.json" => write_json(w, &scan.record(config, Measured::Nothing)?)?,
        "steps.jsonl" => scan.steps.iter().try_for_each(|step| write_json(w, step))?,
        "views.csv" => write_views(w, &scan.steps)?,
        "waypoints.csv" => write_waypoints(w, scan)?,
        "map.ot" => octree()?.write_ot(&mut *w)?,
        "map.bt" => octree()?.write_bt(&mut *w)?,
        "cloud.ply" => write_cloud(&mut *w, &scan.model(config.model)?.cloud)?,
        "mesh.ply" => {
            let model = scan.model(config.model)?;
            write_mesh(&mut *w, &model.vertices, model.is_filled(), model.triangles())?;
        }
        name => return Err(Fault::of_value("name", name, RESULT_FILES.join(", "))),
    }
    Ok(std::mem::take(w))
}

fn octree_of(octree: &Result<Octree, nextview::Error>) -> Result<&Octree, Fault> {
    octree.as_ref().map_err(Fault::data)
}

/// One JSON object on a line.
fn write_json(writer: &mut Vec<u8>, value: &impl serde::Serialize) -> Result<(), Fault> {
    serde_json::to_writer(&mut *writer, value).map_err(Fault::data)?;
    writer.push(b'\n');
    Ok(())
}

fn write_views(writer: &mut Vec<u8>, steps: &[StepRecord]) -> Result<(), Fault> {
    writeln!(writer, "step,view,x_m,y_m,z_m,qx,qy,qz,qw")?;
    for step in steps {
        let view = step.view.map(|view| view.to_string()).unwrap_or_default();
        let ([x, y, z], [qx, qy, qz, qw]) = (step.position_m, step.quaternion_xyzw);
        writeln!(writer, "{},{view},{x},{y},{z},{qx},{qy},{qz},{qw}", step.step)?;
    }
    Ok(())
}

/// The trajectory from the preceding view to each view, with times since the camera set off there.
fn write_waypoints(writer: &mut Vec<u8>, scan: &ScanState<'_>) -> Result<(), Fault> {
    let names = scan.joint_trajectories.iter().flatten().next().map_or(&[][..], |joints| &joints.names);
    write!(writer, "step,time_s,x_m,y_m,z_m,qx,qy,qz,qw")?;
    names.iter().try_for_each(|name| write!(writer, ",{}", csv_field(name)))?;
    writeln!(writer)?;
    let motions = scan.trajectories.iter().zip(&scan.joint_trajectories);
    for (step, (trajectory, joints)) in scan.steps.iter().zip(motions) {
        for (i, Waypoint { time, world_from_camera }) in trajectory.waypoints().iter().enumerate() {
            write!(writer, "{},{time},{}", step.step, numbers(world_from_camera))?;
            match joints {
                Some(joints) => joints.points[i].1.iter().try_for_each(|value| write!(writer, ",{value}"))?,
                None => names.iter().try_for_each(|_| write!(writer, ","))?,
            }
            writeln!(writer)?;
        }
    }
    Ok(())
}

/// Position and quaternion, separated by commas.
fn numbers(world_from_camera: &Pose) -> String {
    let (t, q) = (world_from_camera.translation(), world_from_camera.rotation());
    format!("{},{},{},{},{},{},{}", t.x, t.y, t.z, q.x, q.y, q.z, q.w)
}
