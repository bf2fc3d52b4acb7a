use super::file::{self, Place, Record};
use super::messages::{self, Image};
use crate::frame::DepthSource;
use crate::recording::{ReadOptions, Recording, Skipped};
use crate::trajectory::{Stamped, Trajectory};
use crate::{RecordedFrame, RecordingError, limits};
use nextview::geometry::Pose;
use nextview::sensor::Intrinsics;
use std::collections::{BTreeMap, HashMap};
use std::path::Path;

/// The content of the file, by topic.
#[derive(Default)]
struct Topics {
    cameras: BTreeMap<String, Intrinsics>,
    images: BTreeMap<String, Vec<Stamped<Place>>>,
    poses: BTreeMap<String, Vec<Stamped<Pose>>>,
    /// Number of images and poses.
    n_entries: usize,
}

pub(crate) fn read(path: &Path, options: &ReadOptions) -> Result<Recording, RecordingError> {
    let Topics { cameras, mut images, mut poses, .. } = Topics::read(path)?;
    let depth_topic = chosen("depth image", &images, "depth_topic", options.depth_topic.as_deref())?;
    let pose_topic = chosen("PoseStamped", &poses, "pose_topic", options.pose_topic.as_deref())?;
    let intrinsics = cameras[&camera_topic(&cameras, &depth_topic)?];
    let images = Stamped::sorted(images.remove(&depth_topic).unwrap_or_default())?;
    let poses = Stamped::sorted(poses.remove(&pose_topic).unwrap_or_default())?;
    let trajectory = Trajectory::new(poses, options.pose_tolerance_s);
    let (mut frames, mut skipped) = (Vec::new(), Vec::new());
    for Stamped { time, place: name, value: place } in images {
        match trajectory.at(time) {
            Err(why) => skipped.push(Skipped { what: name, why }),
            Ok(world_from_camera) => frames.push(RecordedFrame {
                name,
                timestamp_s: Some(time),
                world_from_camera,
                intrinsics,
                depth: DepthSource::Message { path: path.to_owned(), place },
                color: None,
            }),
        }
    }
    Ok(Recording { intrinsics, frames, skipped, notes: Vec::new() })
}

impl Topics {
    fn read(path: &Path) -> Result<Self, RecordingError> {
        let mut topics = Self::default();
        let mut schemas: HashMap<u16, String> = HashMap::new();
        let mut channels: HashMap<u16, (u16, String)> = HashMap::new();
        let mut counts: HashMap<u16, usize> = HashMap::new();
        let n_bytes = path.metadata()?.len();
        file::walk(path, |place, record| {
            match record {
                Record::Schema { id, name } => _ = schemas.insert(id, name.to_owned()),
                Record::Channel { id, schema, topic, encoding: "cdr" } => {
                    channels.insert(id, (schema, topic.to_owned()));
                }
                Record::Channel { .. } => {}
                Record::Message { channel, data } => {
                    let Some((schema, topic)) = channels.get(&channel) else { return Ok(()) };
                    let count = counts.entry(channel).or_default();
                    *count += 1;
                    let schema = schemas.get(schema).map_or("", String::as_str);
                    let name = format!("message {count} of {topic}");
                    topics
                        .add(schema, topic, &name, place, data)
                        .map_err(|error| RecordingError::format(name, error.to_string()))?;
                    limits::check_entries(topics.n_entries, n_bytes)?;
                }
            }
            Ok(())
        })?;
        Ok(topics)
    }

    /// Adds a message if its kind is needed.
    fn add(
        &mut self,
        schema: &str,
        topic: &str,
        name: &str,
        place: Place,
        data: &[u8],
    ) -> Result<(), RecordingError> {
        let place_name = name.to_owned();
        match schema {
            "sensor_msgs/msg/CameraInfo" => {
                let camera = messages::camera_info(data)?;
                let first = *self.cameras.entry(topic.to_owned()).or_insert(camera);
                if camera != first {
                    return Err(RecordingError::Content("the intrinsics change, expected one camera".into()));
                }
            }
            "sensor_msgs/msg/Image" => {
                let image = Image::new(data)?;
                if image.is_depth() {
                    let stamped = Stamped { time: image.time, place: place_name, value: place };
                    self.images.entry(topic.to_owned()).or_default().push(stamped);
                    self.n_entries += 1;
                }
            }
            "geometry_msgs/msg/PoseStamped" => {
                let (time, value) = messages::pose_stamped(data)?;
                let stamped = Stamped { time, place: place_name, value };
                self.poses.entry(topic.to_owned()).or_default().push(stamped);
                self.n_entries += 1;
            }
            _ => {}
        }
        Ok(())
    }
}

/// The topic that was asked for, or else the only one.
fn chosen<T>(
    what: &str,
    topics: &BTreeMap<String, T>,
    option: &str,
    wanted: Option<&str>,
) -> Result<String, RecordingError> {
    let names: Vec<&str> = topics.keys().map(String::as_str).collect();
    let problem = match (wanted, names.as_slice()) {
        (Some(wanted), _) if topics.contains_key(wanted) => return Ok(wanted.to_owned()),
        (None, [only]) => return Ok((*only).to_owned()),
        (_, []) => format!("there is no {what} topic, expected ROS 2 messages in CDR"),
        (Some(wanted), _) => {
            format!("`{option}` is {wanted}, but there are the {what} topics {}", names.join(", "))
        }
        (None, _) => {
            format!("there are several {what} topics, {}: choose one as `{option}`", names.join(", "))
        }
    };
    Err(RecordingError::Content(problem))
}

/// The optics of a depth topic: those beside it, or else the only ones.
fn camera_topic(cameras: &BTreeMap<String, Intrinsics>, depth_topic: &str) -> Result<String, RecordingError> {
    let folder = |topic: &str| topic.rsplit_once('/').map_or(String::new(), |(folder, _)| folder.to_owned());
    let beside: Vec<&String> = cameras.keys().filter(|topic| folder(topic) == folder(depth_topic)).collect();
    let all: Vec<&String> = cameras.keys().collect();
    match (beside.as_slice(), all.as_slice()) {
        ([only], _) | ([], [only]) => Ok((*only).clone()),
        (_, []) => Err(RecordingError::Content(
            "there is no CameraInfo topic, expected ROS 2 messages in CDR".into(),
        )),
        (_, names) => Err(RecordingError::Content(format!(
            "none of the CameraInfo topics, {names:?}, is the one beside {depth_topic}"
        ))),
    }
}
