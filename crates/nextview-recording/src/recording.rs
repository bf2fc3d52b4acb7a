use crate::frame::uselessness;
use crate::{RecordedFrame, RecordingError, folder, mcap, tum};
use nextview::sensor::Intrinsics;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::fmt;
use std::path::Path;

/// Frames of one camera, in the order in which they were taken.
///
/// Opening reads every image once and keeps none, so that whatever is wrong is told at once: what contradicts itself is an
/// error, what only lacks its counterpart or shows nothing is [left out](Self::skipped).
///
/// ```no_run
/// use nextview_recording::{ReadOptions, Recording};
///
/// let recording = Recording::open("kitchen.mcap".as_ref(), &ReadOptions::default())?;
/// for frame in &recording.frames {
///     println!("{} at {}", frame.name, frame.world_from_camera.translation());
///     let frame = frame.load()?; // what a session observes
///     assert_eq!(frame.intrinsics(), &recording.intrinsics);
/// }
/// # Ok::<(), nextview_recording::RecordingError>(())
/// ```
#[derive(Debug)]
pub struct Recording {
    /// The camera's optics.
    pub intrinsics: Intrinsics,
    /// At least one frame.
    pub frames: Vec<RecordedFrame>,
    /// What was left out, in the order of the files.
    pub skipped: Vec<Skipped>,
    /// What else is odd and was put up with.
    pub notes: Vec<String>,
}

/// Something that was left out of a recording.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Skipped {
    /// What: an image or a pose, by name.
    pub what: String,
    /// Why.
    pub why: String,
}

/// How to read a recording where it leaves a choice.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ReadOptions {
    /// Of our own folder: what the pose columns' names begin with, such as `given` for `given_00` to `given_23`. By default
    /// `world_from_camera`, or else the only such set of columns.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pose_columns: Option<String>,
    /// Of MCAP: the topic of the depth images, needed if there are several.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub depth_topic: Option<String>,
    /// Of MCAP: the topic of the camera's poses, needed if there are several.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pose_topic: Option<String>,
    /// Of TUM and MCAP: how far apart in time, seconds, an image and its pose may be, and of TUM its colour. Default 0.02.
    pub pose_tolerance_s: f64,
}

impl Default for ReadOptions {
    fn default() -> Self {
        Self { pose_columns: None, depth_topic: None, pose_topic: None, pose_tolerance_s: 0.02 }
    }
}

impl ReadOptions {
    fn check(&self) -> Result<(), RecordingError> {
        let tolerance = self.pose_tolerance_s;
        if tolerance >= 0.0 && tolerance.is_finite() {
            return Ok(());
        }
        Err(RecordingError::Content(format!(
            "pose_tolerance_s is {tolerance}, expected a number of seconds, at least 0"
        )))
    }
}

impl fmt::Display for Skipped {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} is left out: {}", self.what, self.why)
    }
}

impl Recording {
    /// Reads a recording: a folder with `poses.csv`, `intrinsics.txt` and `depth/`, a folder with `depth.txt`,
    /// `groundtruth.txt` and `intrinsics.txt` (TUM RGB-D), or an MCAP file with ROS 2 messages.
    pub fn open(path: &Path, options: &ReadOptions) -> Result<Self, RecordingError> {
        options.check()?;
        let is_there = |name: &str| path.join(name).exists();
        let recording = match path.metadata() {
            Err(error) => Err(error.into()),
            Ok(what) if what.is_file() => mcap::read(path, options),
            Ok(_) if is_there("poses.csv") => folder::read(path, options),
            Ok(_) if is_there("depth.txt") || is_there("groundtruth.txt") => tum::read(path, options),
            Ok(_) => Err(RecordingError::Content(
                "is no recording, expected a folder with poses.csv, intrinsics.txt and depth/, or a folder of TUM RGB-D with \
                 depth.txt, groundtruth.txt and intrinsics.txt, or an .mcap file"
                    .into(),
            )),
        };
        // What is wrong in a file of the folder names that file already.
        let recording = recording.map_err(|error| match error {
            RecordingError::InFile { .. } => error,
            error => error.in_file(path),
        });
        let recording = recording?.without_useless_frames().map_err(|error| match error {
            RecordingError::Content(_) => error.in_file(path),
            error => error,
        })?;
        recording.with_checked_colors()
    }

    /// Reads all images and leaves out those that show nothing.
    fn without_useless_frames(mut self) -> Result<Self, RecordingError> {
        let checks = self.frames.par_iter().map(|frame| Ok(uselessness(frame.load()?.image())));
        let checks: Vec<Option<String>> = checks.collect::<Result<_, RecordingError>>()?;
        let mut kept = Vec::new();
        for (frame, why) in self.frames.into_iter().zip(checks) {
            match why {
                Some(why) => self.skipped.push(Skipped { what: frame.name, why }),
                None => kept.push(frame),
            }
        }
        if kept.is_empty() {
            let first = self.skipped.first().map(|skipped| format!("; {skipped}")).unwrap_or_default();
            return Err(RecordingError::Content(format!("holds no usable frame{first}")));
        }
        Ok(Self { frames: kept, ..self })
    }

    /// Reads all colour images, and notes where some frames lack one.
    fn with_checked_colors(mut self) -> Result<Self, RecordingError> {
        self.frames.par_iter().try_for_each(|frame| frame.load_color().map(drop))?;
        let n_colored = self.frames.iter().filter(|frame| frame.has_color()).count();
        if n_colored > 0 && n_colored < self.frames.len() {
            let n_frames = self.frames.len();
            self.notes.push(format!("{} of {n_frames} frames have no colour image", n_frames - n_colored));
        }
        Ok(self)
    }
}
