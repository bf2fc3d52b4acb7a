use crate::RecordingError;
use crate::frame::RecordedFrame;
use nextview::geometry::Pose;
use nextview::sensor::{CameraAxes, Intrinsics};
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::fmt;

/// Frames of one camera, in the order in which they were taken.
///
/// Opening reads every image once and keeps none, which reports all faults at once. Contradictory data is an
/// error; entries that lack a counterpart or show nothing are [left out](Self::skipped).
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
    /// The entries left out, in file order.
    pub skipped: Vec<Skipped>,
    /// Other oddities that were tolerated.
    pub notes: Vec<String>,
}

/// Maximum memory for loading the frames of a group, in bytes.
const GROUP: usize = 1 << 26;

impl Recording {
    /// The frames in order, in groups that fit into memory together.
    pub fn groups(&self) -> impl Iterator<Item = &[RecordedFrame]> {
        let mut rest = self.frames.as_slice();
        std::iter::from_fn(move || {
            let mut cost = 0;
            let is_within = |frame: &&RecordedFrame| {
                cost += frame.cost();
                cost <= GROUP
            };
            let n = rest.iter().take_while(is_within).count().max(1).min(rest.len());
            let (group, after) = rest.split_at(n);
            rest = after;
            (!group.is_empty()).then_some(group)
        })
    }
}

/// An entry left out of a recording.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Skipped {
    /// Name of the image or pose.
    pub what: String,
    /// The reason.
    pub why: String,
}

/// Direction of recorded poses.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum PoseDirection {
    /// Takes points from camera to world: the camera's place. The default.
    #[default]
    WorldFromCamera,
    /// Takes points from world to camera: the extrinsics of many calibrations.
    CameraFromWorld,
}

/// Options for ambiguous recordings.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields, remote = "Self")]
pub struct ReadOptions {
    /// For our own folders: prefix of the pose columns, such as `given` for `given_00` to `given_23`.
    /// Default: `world_from_camera`, or the only such set of columns.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pose_columns: Option<String>,
    /// Axis convention of the cameras with recorded poses. Default `opencv`.
    pub camera_axes: CameraAxes,
    /// Direction of the recorded poses. Default `world-from-camera`.
    pub poses: PoseDirection,
    /// For MCAP: the topic of the depth images, required if there are several.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub depth_topic: Option<String>,
    /// For MCAP: the topic of the camera's poses, required if there are several.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pose_topic: Option<String>,
    /// For MCAP: the world frame for transforms to the camera. Default: the root of the camera's tree of
    /// frames, if there is no topic of poses.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub world_frame: Option<String>,
    /// For MCAP: the topic of colour images that match the depth pixel by pixel. By default none, because a
    /// match cannot be verified.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub color_topic: Option<String>,
    /// For TUM and MCAP: maximum time in seconds between an image and its pose, and its colour if that has a
    /// time. Default 0.02.
    pub pose_tolerance_s: f64,
}

impl Serialize for ReadOptions {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        Self::serialize(self, serializer)
    }
}

impl<'de> Deserialize<'de> for ReadOptions {
    /// Fails if a value is out of range.
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let options = Self::deserialize(deserializer)?;
        options.check().map_err(serde::de::Error::custom)?;
        Ok(options)
    }
}

impl Default for ReadOptions {
    fn default() -> Self {
        Self {
            pose_columns: None,
            camera_axes: CameraAxes::default(),
            poses: PoseDirection::default(),
            depth_topic: None,
            pose_topic: None,
            world_frame: None,
            color_topic: None,
            pose_tolerance_s: 0.02,
        }
    }
}

impl ReadOptions {
    /// Converts a recorded pose to that of the camera.
    pub(crate) fn world_from_camera(&self, recorded: &Pose) -> Pose {
        self.camera_axes.to_opencv(&match self.poses {
            PoseDirection::WorldFromCamera => *recorded,
            PoseDirection::CameraFromWorld => recorded.inverse(),
        })
    }

    /// Fails on the first value that is out of range.
    pub fn check(&self) -> Result<(), RecordingError> {
        if let (Some(topic), Some(frame)) = (&self.pose_topic, &self.world_frame) {
            let problem = format!(
                "poses come either from the topic {topic} or from transforms, so leave out the frame {frame}"
            );
            return Err(RecordingError::Option { key: "world_frame", problem });
        }
        let tolerance = self.pose_tolerance_s;
        if tolerance >= 0.0 && tolerance.is_finite() {
            return Ok(());
        }
        let problem = format!("{tolerance} is out of range, expected a number of seconds, at least 0,");
        Err(RecordingError::Option { key: "pose_tolerance_s", problem })
    }
}

impl fmt::Display for Skipped {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} is left out: {}", self.what, self.why)
    }
}
