use crate::results::FRAMES_FOLDER;
use crate::{Fault, ScanConfig, ScanRecord};
use glam::DVec3;
use nextview::Cancel;
use nextview::geometry::Aabb;
use nextview::placement::ShownObject;
use nextview::registration::RegistrationConfig;
use nextview::sensor::{ColorImage, Frame};
use nextview::session::shown_object;
use nextview_recording::{ReadOptions, RecordedFrame, Recording};
use std::path::{Path, PathBuf};

const RESTORE: &str = "restore the files of that scan, or scan the object again";

/// A finished scan of an object that has been turned since.
pub(crate) struct EarlierScan {
    /// The object as shown by that scan.
    pub shown: ShownObject,
    frames: Vec<RecordedFrame>,
}

impl EarlierScan {
    /// Reads the results in a folder. Fails if they are not those of one placement on a table.
    pub fn open(dir: &Path, cancel: &Cancel) -> Result<Self, Fault> {
        check_there(dir)?;
        let record = ScanRecord::read(dir)?;
        let fault = |problem: &str, remedy: &str| Fault::data(problem).in_file(dir).with_remedy(remedy);
        if record.turn.is_some() {
            return Err(fault(
                "holds a scan that continued another one, and cannot be continued itself",
                "set `after` to the results of the first scan of the object",
            ));
        }
        let Recording { frames, skipped, .. } =
            Recording::open(&dir.join(FRAMES_FOLDER), &ReadOptions::default())?;
        // A scan's own results are consistent; files changed since would give another object.
        if let Some(skipped) = skipped.first() {
            let fault =
                Fault::data(format!("a frame cannot be read: {skipped}")).in_file(&dir.join(FRAMES_FOLDER));
            return Err(fault.with_remedy(RESTORE));
        }
        if frames.len() > record.steps.len() {
            let (n, n_steps) = (frames.len(), record.steps.len());
            let problem =
                format!("holds {n} frames, but record.json has {n_steps}: they are from different scans");
            return Err(fault(&problem, RESTORE));
        }
        let Some(table) = record.table() else {
            return Err(fault(
                "holds a scan without a table, so the side on which the object stood is unknown",
                "if the object will be turned, scan it with `object_box.table` = fit or known",
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

    /// The colours of a frame, by index.
    pub fn color(&self, i: usize) -> Result<Option<ColorImage>, Fault> {
        Ok(self.frames[i].load_color()?)
    }
}

impl ScanConfig {
    /// The configuration as stored in a file of this folder, for [`found_from`](Self::found_from) to read,
    /// with an explicit [mode of registration](RegistrationConfig::enabled). The path of the earlier results
    /// is relative to this folder if both folders share a parent, which can then be moved as a whole.
    /// Otherwise it is absolute, and does not depend on the working directory.
    pub fn kept_in(&self, dir: &Path) -> Self {
        let after = self.after.as_deref().map(|after| named_from(dir, after));
        let registration =
            RegistrationConfig { enabled: Some(self.registration_mode()), ..self.registration };
        Self { after, registration, ..self.clone() }
    }

    /// Resolves the configuration of a file in this folder. Paths that begin with `..` are relative to the
    /// folder; all others, and those that do not exist there, to the working directory.
    pub fn found_from(mut self, dir: &Path) -> Self {
        let beside = self.after.as_ref().and_then(|after| {
            let rest = after.strip_prefix("..").ok()?;
            let beside = std::path::absolute(dir).ok()?.parent()?.join(rest);
            (holds_results(&beside) || !holds_results(after)).then_some(beside)
        });
        self.after = beside.or(self.after);
        self
    }

    /// Fails if the results of the earlier scan, which this one continues, are not where they were.
    pub fn check_earlier(&self) -> Result<(), Fault> {
        self.after.as_deref().map_or(Ok(()), check_there)
    }
}

fn holds_results(dir: &Path) -> bool {
    dir.join("record.json").is_file()
}

fn check_there(dir: &Path) -> Result<(), Fault> {
    if dir.exists() {
        return Ok(());
    }
    let fault = Fault::data("holds no results of a scan to continue: it does not exist").in_file(dir);
    Err(fault.with_remedy("restore that folder, or start in the folder to which its path is relative"))
}

fn named_from(dir: &Path, after: &Path) -> PathBuf {
    let real = |path: &Path| path.canonicalize().or_else(|_| std::path::absolute(path));
    let Ok(after) = real(after) else { return after.to_owned() };
    let dir = std::path::absolute(dir).ok();
    let around = dir.as_deref().and_then(Path::parent).and_then(|around| real(around).ok());
    match around.and_then(|around| after.strip_prefix(around).ok().map(Path::to_owned)) {
        Some(rest) => Path::new("..").join(rest),
        None => after,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    fn after(path: impl Into<PathBuf>) -> ScanConfig {
        ScanConfig { after: Some(path.into()), ..ScanConfig::default() }
    }

    #[test]
    fn an_earlier_scan_is_found_after_both_were_moved() {
        let folder = std::env::temp_dir().join(format!("nextview-earlier-{}", std::process::id()));
        let scans = folder.join("scans");
        for name in ["mug", "turned"] {
            fs::create_dir_all(scans.join(name)).unwrap();
        }
        fs::write(scans.join("mug/record.json"), "").unwrap();
        let kept = after(scans.join("turned/../mug")).kept_in(&scans.join("turned"));
        assert_eq!(kept.after, Some(PathBuf::from("../mug")));
        let moved = folder.join("moved");
        fs::rename(&scans, &moved).unwrap();
        let found = kept.clone().found_from(&moved.join("turned"));
        assert_eq!(found.after, Some(moved.join("mug")));
        found.check_earlier().unwrap();
        // For a folder elsewhere, the absolute path.
        let elsewhere = after(moved.join("mug")).kept_in(&folder.join("other/turned"));
        assert_eq!(elsewhere.after, Some(moved.join("mug").canonicalize().unwrap()));
        assert_eq!(elsewhere.clone().found_from(&folder), elsewhere);
        // Without `..`, relative to the working directory.
        assert_eq!(after("scans/mug").found_from(&moved.join("turned")), after("scans/mug"));
        fs::remove_dir_all(&folder).unwrap();
        let fault = found.check_earlier().unwrap_err().to_string();
        assert!(fault.ends_with("mug: holds no results of a scan to continue: it does not exist"), "{fault}");
    }
}
