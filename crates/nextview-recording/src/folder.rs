//! Our own format: `intrinsics.txt`, `poses.csv`, and numbered images in `depth/` and, if there is colour, in
//! `color/`.

use crate::frame::{ColorSource, DepthSource};
use crate::lens::{self, Lens};
use crate::recording::{ReadOptions, Recording, Skipped};
use crate::rigid::{self, Rigid};
use crate::text::{self, TextLine};
use crate::trajectory::Stamped;
use crate::{RecordedFrame, RecordingError};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Default metres per unit of depth, if intrinsics.txt does not state it.
const DEPTH_UNIT: f64 = 0.001;

/// Extensions of colour images.
const COLOR_EXTENSIONS: [&str; 3] = ["png", "jpg", "jpeg"];

/// Suffixes of the twelve columns of a pose, by rows.
const ENTRIES: [&str; 12] =
    ["_00", "_01", "_02", "_03", "_10", "_11", "_12", "_13", "_20", "_21", "_22", "_23"];

/// Prefix of the pose columns.
const POSE: &str = "world_from_camera";

/// Deviation of a rotation up to which there is no note: rounding in files with few digits.
const NOTED: f64 = 1e-3;

/// A row of poses.csv.
pub(crate) struct PoseRow {
    line: usize,
    timestamp_s: Option<f64>,
    rigid: Rigid,
}

pub(crate) fn read(folder: &Path, options: &ReadOptions) -> Result<Recording, RecordingError> {
    let Lens { intrinsics, depth_unit } = lens::read(&folder.join("intrinsics.txt"), DEPTH_UNIT)?;
    let path = folder.join("poses.csv");
    let rows =
        text::read(&path).and_then(|text| rows(&text, options)).map_err(|error| error.in_file(&path))?;
    let notes = note(&rows).into_iter().collect();
    let mut images = images(&folder.join("depth"), &["png"])?;
    let masks = folder.join("mask");
    let mut masks = masks.is_dir().then(|| self::images(&masks, &["png"])).transpose()?;
    let mut colors = match folder.join("color") {
        folder if folder.is_dir() => self::images(&folder, &COLOR_EXTENSIONS)?,
        _ => BTreeMap::new(),
    };
    let (mut frames, mut skipped) = (Vec::new(), Vec::new());
    for (number, row) in rows {
        let Some(path) = images.remove(&number) else {
            let what = format!("the pose of frame {number} (poses.csv, line {})", row.line);
            skipped.push(Skipped { what, why: "depth/ has no image with that number".into() });
            continue;
        };
        let name = format!("frame {number}");
        let mask = masks.as_mut().map(|masks| masks.remove(&number));
        if mask == Some(None) {
            skipped.push(Skipped { what: name, why: "mask/ has no image with that number".into() });
            continue;
        }
        frames.push(RecordedFrame {
            name,
            timestamp_s: row.timestamp_s,
            world_from_camera: row.rigid.pose,
            intrinsics,
            depth: DepthSource::Png { path, unit: depth_unit, mask: mask.flatten() },
            color: colors.remove(&number).map(ColorSource::File),
        });
    }
    skipped.extend(images.into_keys().map(|number| Skipped {
        what: format!("the image of frame {number}"),
        why: "poses.csv has no row for that frame".into(),
    }));
    Ok(Recording { intrinsics, frames, skipped, notes })
}

/// A note about matrices that were not rotations.
fn note(rows: &BTreeMap<u32, PoseRow>) -> Option<String> {
    let worst = rows.values().map(|row| row.rigid.error).fold(0.0, f64::max);
    (worst > NOTED).then(|| {
        format!(
            "the rotations in poses.csv have scale or shear of up to {:.1} %; the nearest pure rotations are used",
            1e2 * worst
        )
    })
}

/// The images by number. Files with other extensions are ignored.
fn images(folder: &Path, extensions: &[&str]) -> Result<BTreeMap<u32, PathBuf>, RecordingError> {
    let list = || {
        let entries = std::fs::read_dir(folder)?.collect::<Result<Vec<_>, _>>()?;
        Ok::<_, RecordingError>(entries.into_iter().map(|entry| entry.path()).collect::<Vec<PathBuf>>())
    };
    let mut paths = list().map_err(|error| error.in_file(folder))?;
    paths.sort();
    let mut images: BTreeMap<u32, PathBuf> = BTreeMap::new();
    let is_image =
        |path: &PathBuf| extensions.iter().any(|known| path.extension().is_some_and(|e| e == *known));
    for path in paths.into_iter().filter(is_image) {
        let stem = path.file_stem().unwrap_or_default().to_string_lossy();
        let number = stem.parse().map_err(|_| {
            let example = extensions[0];
            let problem =
                format!("is not a frame number, expected names such as 000.{example} and 001.{example}");
            RecordingError::Content(problem).in_file(&path)
        })?;
        if let Some(other) = images.get(&number) {
            let problem = format!("frame {number} already has an image, {}", other.display());
            return Err(RecordingError::Content(problem).in_file(&path));
        }
        images.insert(number, path);
    }
    Ok(images)
}

/// The rows of poses.csv by frame number.
pub(crate) fn rows(text: &str, options: &ReadOptions) -> Result<BTreeMap<u32, PoseRow>, RecordingError> {
    let mut lines = text::lines(text);
    let header = lines.next().ok_or_else(|| RecordingError::Content("is empty, expected a header".into()))?;
    let columns = PoseColumns::new(&header, options)?;
    let mut rows: BTreeMap<u32, PoseRow> = BTreeMap::new();
    let mut times = Vec::new();
    for line in lines {
        let (number, row) = columns.row(&line)?;
        if let Some(other) = rows.get(&number) {
            return Err(line.error(format!("frame {number} is already in line {}", other.line)));
        }
        times.extend(row.timestamp_s.map(|time| Stamped { time, place: line.place(), value: () }));
        rows.insert(number, row);
    }
    if rows.is_empty() {
        return Err(RecordingError::Content("holds no pose, expected a row for every frame".into()));
    }
    Stamped::sorted(times)?;
    Ok(rows)
}

/// The meaning of the columns.
struct PoseColumns {
    n_columns: usize,
    frame: usize,
    timestamp: Option<usize>,
    pose: [usize; 12],
}

impl PoseColumns {
    fn new(header: &TextLine<'_>, options: &ReadOptions) -> Result<Self, RecordingError> {
        let names = header.fields();
        let find = |name: &str| names.iter().position(|field| field.eq_ignore_ascii_case(name));
        let prefix = pose_prefix(header, &names, options)?;
        let column = |entry: &str| {
            let name = format!("{prefix}{entry}");
            find(&name).ok_or_else(|| header.error(format!("there is no column {name}")))
        };
        let mut pose = [0; 12];
        for (place, entry) in pose.iter_mut().zip(ENTRIES) {
            *place = column(entry)?;
        }
        let frame = find("frame").ok_or_else(|| header.error("there is no column frame"))?;
        Ok(Self { n_columns: names.len(), frame, timestamp: find("timestamp_s"), pose })
    }

    fn row(&self, line: &TextLine<'_>) -> Result<(u32, PoseRow), RecordingError> {
        let fields = line.fields();
        if fields.len() != self.n_columns {
            return Err(line.error(format!("{} columns, expected {}", fields.len(), self.n_columns)));
        }
        let number = line.value("frame", fields[self.frame])?;
        let timestamp_s =
            self.timestamp.map(|column| line.value("timestamp_s", fields[column])).transpose()?;
        let mut matrix = [0.0; 12];
        for (entry, &column) in matrix.iter_mut().zip(&self.pose) {
            *entry = line.value(format!("column {}", column + 1), fields[column])?;
        }
        let rigid =
            rigid::from_rows(matrix).map_err(|problem| line.error(format!("frame {number}: {problem}")))?;
        Ok((number, PoseRow { line: line.number, timestamp_s, rigid }))
    }
}

/// Prefix of the pose columns: the requested one, ours, or the only choice.
fn pose_prefix(
    header: &TextLine<'_>,
    names: &[&str],
    options: &ReadOptions,
) -> Result<String, RecordingError> {
    let complete =
        |prefix: &&str| ENTRIES.iter().all(|entry| names.contains(&format!("{prefix}{entry}").as_str()));
    let prefixes: Vec<&str> =
        names.iter().filter_map(|name| name.strip_suffix(ENTRIES[0])).filter(complete).collect();
    let wanted = options.pose_columns.as_deref();
    match (wanted.or_else(|| prefixes.contains(&POSE).then_some(POSE)), prefixes.as_slice()) {
        (Some(prefix), _) if prefixes.contains(&prefix) => Ok(prefix.to_owned()),
        (None, [prefix]) => Ok((*prefix).to_owned()),
        (_, []) => {
            Err(header
                .error(format!("there are no pose columns, expected {POSE}_00 to {POSE}_23, row by row")))
        }
        (Some(prefix), others) => Err(header.error(format!(
            "there are no pose columns {prefix}_00 to {prefix}_23, but {}",
            others.join(", ")
        ))),
        (None, several) => {
            let (place, names) = (header.place(), several.join(", "));
            let problem = format!("{place}: there are several sets of pose columns, {names}: choose one");
            Err(RecordingError::Option { key: "pose_columns", problem })
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const POSE_ROW: &str = "1,0,0,0.1,0,1,0,0.2,0,0,1,0.3";

    fn header(prefix: &str) -> String {
        ENTRIES.map(|entry| format!("{prefix}{entry}")).join(",")
    }

    fn read(text: &str, wanted: Option<&str>) -> Result<Vec<u32>, String> {
        let options = ReadOptions { pose_columns: wanted.map(str::to_owned), ..ReadOptions::default() };
        rows(text, &options).map(|rows| rows.into_keys().collect()).map_err(|error| error.to_string())
    }

    #[test]
    fn rows_are_sorted_and_columns_found_by_name() {
        let text = format!("note,frame,{}\nx,7,{POSE_ROW}\n\n# no\ny,3,{POSE_ROW}\n", header("given"));
        assert_eq!(read(&text, None), Ok(vec![3, 7]));
        let both = format!("frame,{},{}\n3,{POSE_ROW},{POSE_ROW}\n", header("given"), header("refined"));
        assert!(
            read(&both, None)
                .unwrap_err()
                .contains("line 1: there are several sets of pose columns, given, refined")
        );
        assert_eq!(read(&both, Some("refined")), Ok(vec![3]));
        assert!(
            read(&both, Some("best"))
                .unwrap_err()
                .contains("no pose columns best_00 to best_23, but given, refined")
        );
        let ours = both.replace("given", POSE);
        assert_eq!(read(&ours, None), Ok(vec![3]));
    }

    #[test]
    fn faults_name_the_lines() {
        let head = format!("frame,timestamp_s,{}\n", header(POSE));
        let row = |frame: &str, time: &str| format!("{frame},{time},{POSE_ROW}\n");
        for (rows, expected) in [
            (String::new(), "holds no pose"),
            (row("1", "0.1") + &row("1", "0.2"), "line 3: frame 1 is already in line 2"),
            (row("1", "0.1") + &row("2", "0.1"), "line 3: has the same timestamp, 0.1, as line 2"),
            (row("1", "nan"), "line 2: the timestamp is NaN"),
            (row("-1", "0.1"), "line 2: frame is '-1', expected a whole number"),
            (row("1", "0.1").replace("0.2", "x"), "line 2: column 10 is 'x', expected a number"),
            (row("1", "0.1").replace(",0.3", ""), "line 2: 13 columns, expected 14"),
            (row("1", "0.1").replace("0.3", "300"), "line 2: frame 1: the position is 300 m from the origin"),
            (row("1", "0.1").replace("0.1,0,1,", "0.1,0,2,"), "line 2: frame 1: the rotation is not rigid"),
        ] {
            let error = read(&format!("{head}{rows}"), None).unwrap_err();
            assert!(error.contains(expected), "{rows}: {error}");
        }
        assert!(read("", None).unwrap_err().contains("is empty"));
        assert!(
            read("frame,x\n", None)
                .unwrap_err()
                .contains("line 1: there are no pose columns, expected world_from")
        );
        assert!(read(&header(POSE), None).unwrap_err().contains("line 1: there is no column frame"));
    }
}
