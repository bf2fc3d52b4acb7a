//! The format of the TUM RGB-D benchmark (Sturm et al. 2012): lists of images and of poses with separate
//! timestamps.

use crate::frame::{ColorSource, DepthSource};
use crate::lens::{self, Lens};
use crate::recording::{ReadOptions, Recording, Skipped};
use crate::text::{self, TextLine};
use crate::trajectory::{CameraTrajectory, Stamped, nearest};
use crate::{RecordedFrame, RecordingError, rigid};
use glam::{DQuat, DVec3};
use nextview::geometry::Pose;
use std::path::Path;

/// Default metres per unit of depth, if intrinsics.txt does not state it: the benchmark's factor of 5000.
const DEPTH_UNIT: f64 = 1.0 / 5000.0;

pub(crate) fn read(folder: &Path, options: &ReadOptions) -> Result<Recording, RecordingError> {
    let Lens { intrinsics, depth_unit } = lens::read(&folder.join("intrinsics.txt"), DEPTH_UNIT)?;
    let poses = list(&folder.join("groundtruth.txt"), pose)?;
    let images = list(&folder.join("depth.txt"), image)?;
    let colors = match folder.join("rgb.txt") {
        path if path.exists() => list(&path, image)?,
        _ => Vec::new(),
    };
    let color = |time: f64| {
        let near =
            nearest(&colors, time).filter(|color| (color.time - time).abs() <= options.pose_tolerance_s);
        near.map(|color| folder.join(&color.value)).filter(|path| path.is_file())
    };
    let trajectory = CameraTrajectory::new(poses, options.pose_tolerance_s);
    let (mut frames, mut skipped) = (Vec::new(), Vec::new());
    for Stamped { time, place, value: file } in images {
        let path = folder.join(&file);
        let what = || format!("{file} (depth.txt, {place})");
        let pose = match trajectory.at(time) {
            _ if !path.is_file() => Err("the file does not exist".to_owned()),
            pose => pose,
        };
        match pose {
            Err(why) => skipped.push(Skipped { what: what(), why }),
            Ok(world_from_camera) => frames.push(RecordedFrame {
                name: file,
                timestamp_s: Some(time),
                world_from_camera,
                intrinsics,
                depth: DepthSource::Png { path, unit: depth_unit, mask: None },
                color: color(time).map(ColorSource::File),
            }),
        }
    }
    Ok(Recording { intrinsics, frames, skipped, notes: Vec::new() })
}

/// The entries of a list, sorted by time.
fn list<T>(
    path: &Path,
    parse: impl Fn(&TextLine<'_>, &[&str]) -> Result<T, RecordingError>,
) -> Result<Vec<Stamped<T>>, RecordingError> {
    text::read(path).and_then(|text| entries(&text, parse)).map_err(|error| error.in_file(path))
}

/// Parses the text of a list.
pub(crate) fn entries<T>(
    text: &str,
    parse: impl Fn(&TextLine<'_>, &[&str]) -> Result<T, RecordingError>,
) -> Result<Vec<Stamped<T>>, RecordingError> {
    let entry = |line: TextLine<'_>| {
        let words = line.words();
        let time: f64 = line.value("the timestamp", words[0])?;
        Ok(Stamped { time, place: line.place(), value: parse(&line, &words[1..])? })
    };
    Stamped::sorted(text::lines(text).map(entry).collect::<Result<_, RecordingError>>()?)
}

pub(crate) fn image(line: &TextLine<'_>, words: &[&str]) -> Result<String, RecordingError> {
    match words {
        [file] => Ok((*file).to_owned()),
        _ => Err(line.error(format!("{} words, expected `timestamp file`", words.len() + 1))),
    }
}

pub(crate) fn pose(line: &TextLine<'_>, words: &[&str]) -> Result<Pose, RecordingError> {
    const NAMES: [&str; 7] = ["tx", "ty", "tz", "qx", "qy", "qz", "qw"];
    if words.len() != NAMES.len() {
        let n = words.len() + 1;
        return Err(line.error(format!("{n} numbers, expected `timestamp tx ty tz qx qy qz qw`")));
    }
    let mut numbers = [0.0; 7];
    for ((number, name), word) in numbers.iter_mut().zip(NAMES).zip(words) {
        *number = line.value(name, word)?;
    }
    let [tx, ty, tz, qx, qy, qz, qw] = numbers;
    rigid::from_quaternion(DVec3::new(tx, ty, tz), DQuat::from_xyzw(qx, qy, qz, qw))
        .map_err(|problem| line.error(problem))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn first_line(text: &str) -> TextLine<'_> {
        text::lines(text).next().unwrap()
    }

    fn pose_error(text: &str) -> String {
        let line = first_line(text);
        pose(&line, &line.words()[1..]).unwrap_err().to_string()
    }

    #[test]
    fn poses_are_position_and_quaternion() {
        let line = first_line("1.5 0.1 0.2 0.3 0 0 0.7071 0.7071");
        let pose = pose(&line, &line.words()[1..]).unwrap();
        assert_eq!(pose.translation(), DVec3::new(0.1, 0.2, 0.3));
        assert!((pose.rotation() * DVec3::X).distance(DVec3::Y) < 1e-4);
    }

    #[test]
    fn faults_name_the_line() {
        assert!(pose_error("# t\n1.5 0 0 0 0 0 1").contains("line 2: 7 numbers, expected `timestamp tx"));
        assert!(pose_error("1.5 0 0 0 0 0 1 1").contains("line 1: length of the quaternion is 1.41"));
        assert!(pose_error("1.5 0 0 z 0 0 0 1").contains("line 1: tz is 'z'"));
        assert!(pose_error("1.5 0 0 1500 0 0 0 1").contains("line 1: the position is 1500 m"));
        assert!(pose_error("1.5 0 nan 0 0 0 0 1").contains("line 1: the position is"));
        let line = first_line("1.5 depth.png rgb.png");
        let error = image(&line, &line.words()[1..]).unwrap_err().to_string();
        assert!(error.contains("line 1: 3 words, expected `timestamp file`"));
    }
}
