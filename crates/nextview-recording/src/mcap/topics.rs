use super::file::{self, Record, RecordPosition};
use super::image::ImagePlace;
use super::messages::{self, AnyImage, Packing};
use super::poses::{PoseSource, Transforms};
use crate::frame::{ColorSource, DepthSource};
use crate::recording::{ReadOptions, Recording, Skipped};
use crate::trajectory::{CameraTrajectory, Stamped, nearest};
use crate::{RecordedFrame, RecordingError, limits};
use nextview::geometry::Pose;
use nextview::sensor::Intrinsics;
use std::collections::{BTreeMap, HashMap};
use std::path::Path;

/// The content of the file, by topic.
#[derive(Default)]
struct Topics {
    cameras: BTreeMap<String, Intrinsics>,
    depths: BTreeMap<String, TopicImages>,
    /// Images without depth.
    others: BTreeMap<String, TopicImages>,
    poses: BTreeMap<String, Vec<Stamped<Pose>>>,
    transforms: Transforms,
    /// Number of images and poses.
    n_entries: usize,
}

/// The images of a topic.
struct TopicImages {
    /// Name of the coordinate frame of the camera that took them.
    frame: String,
    places: Vec<Stamped<ImagePlace>>,
}

pub(crate) fn read(path: &Path, options: &ReadOptions) -> Result<Recording, RecordingError> {
    let Topics { cameras, mut depths, mut others, poses, transforms, .. } = Topics::read(path)?;
    let depth_topic = chosen("depth image", &depths, "depth_topic", options.depth_topic.as_deref())?;
    let intrinsics = cameras[&camera_topic(&cameras, &depth_topic)?];
    let TopicImages { frame, places } = depths.remove(&depth_topic).expect("it was chosen from these");
    let notes = transforms.notes();
    let poses = poses_of(poses, transforms, &frame, options)?;
    let colors = match &options.color_topic {
        None => Vec::new(),
        Some(topic) => {
            chosen("colour image", &others, "color_topic", Some(topic))?;
            Stamped::sorted(others.remove(topic).map_or(Vec::new(), |images| images.places))?
        }
    };
    let color = |time: f64| {
        let near =
            nearest(&colors, time).filter(|color| (color.time - time).abs() <= options.pose_tolerance_s);
        near.map(|color| ColorSource::Message { path: path.to_owned(), at: color.value })
    };
    let (mut frames, mut skipped) = (Vec::new(), Vec::new());
    for Stamped { time, place: name, value: at } in Stamped::sorted(places)? {
        match poses.at(time) {
            Err(why) => skipped.push(Skipped { what: name, why }),
            Ok(world_from_camera) => frames.push(RecordedFrame {
                name,
                timestamp_s: Some(time),
                world_from_camera,
                intrinsics,
                depth: DepthSource::Message { path: path.to_owned(), at },
                color: color(time),
            }),
        }
    }
    Ok(Recording { intrinsics, frames, skipped, notes })
}

/// Uses the topic of poses, unless there is none or the options name a world frame.
fn poses_of(
    mut topics: BTreeMap<String, Vec<Stamped<Pose>>>,
    transforms: Transforms,
    camera: &str,
    options: &ReadOptions,
) -> Result<PoseSource, RecordingError> {
    let world = options.world_frame.as_deref();
    let wants_transforms = world.is_some() || (topics.is_empty() && options.pose_topic.is_none());
    if wants_transforms && transforms.n_transforms > 0 {
        return PoseSource::of_transforms(transforms.tree, camera, world);
    }
    if let Some(world) = world {
        let problem = format!("there are no transforms, expected /tf and /tf_static with the frame {world}");
        return Err(RecordingError::Option { key: "world_frame", problem });
    }
    let topic = chosen("PoseStamped", &topics, "pose_topic", options.pose_topic.as_deref())?;
    let poses = Stamped::sorted(topics.remove(&topic).unwrap_or_default())?;
    Ok(PoseSource::Topic(CameraTrajectory::new(poses, options.pose_tolerance_s)))
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
        place: RecordPosition,
        data: &[u8],
    ) -> Result<(), RecordingError> {
        match schema {
            "sensor_msgs/msg/CameraInfo" => {
                let camera = messages::camera_info(data)?;
                let first = *self.cameras.entry(topic.to_owned()).or_insert(camera);
                if camera != first {
                    return Err(RecordingError::Content("the intrinsics change, expected one camera".into()));
                }
            }
            "sensor_msgs/msg/Image" => self.add_image(topic, name, data, place, Packing::Plain)?,
            "sensor_msgs/msg/CompressedImage" => {
                self.add_image(topic, name, data, place, Packing::Compressed)?;
            }
            "geometry_msgs/msg/PoseStamped" => {
                let (time, value) = messages::pose_stamped(data)?;
                let stamped = Stamped { time, place: name.to_owned(), value };
                self.poses.entry(topic.to_owned()).or_default().push(stamped);
                self.n_entries += 1;
            }
            "tf2_msgs/msg/TFMessage" => {
                let is_static = topic.rsplit('/').next() == Some("tf_static");
                for transform in messages::transforms(data)? {
                    self.transforms.add(transform, is_static);
                    self.n_entries += 1;
                }
            }
            _ => {}
        }
        Ok(())
    }

    fn add_image(
        &mut self,
        topic: &str,
        name: &str,
        data: &[u8],
        place: RecordPosition,
        packing: Packing,
    ) -> Result<(), RecordingError> {
        let (header, image) = AnyImage::read(data, packing)?;
        let is_depth = image.is_depth();
        let topics = if is_depth { &mut self.depths } else { &mut self.others };
        let new = || TopicImages { frame: header.frame.to_owned(), places: Vec::new() };
        let images = topics.entry(topic.to_owned()).or_insert_with(new);
        if is_depth && images.frame != header.frame {
            let problem = format!("the frame is '{}', expected '{}' as before", header.frame, images.frame);
            return Err(RecordingError::Content(problem));
        }
        let value = ImagePlace { place, packing };
        images.places.push(Stamped { time: header.time, place: name.to_owned(), value });
        self.n_entries += 1;
        Ok(())
    }
}

/// The requested topic, or the only one.
fn chosen<T>(
    what: &str,
    topics: &BTreeMap<String, T>,
    option: &'static str,
    wanted: Option<&str>,
) -> Result<String, RecordingError> {
    let names: Vec<&str> = topics.keys().map(String::as_str).collect();
    let problem = match (wanted, names.as_slice()) {
        (Some(wanted), _) if topics.contains_key(wanted) => return Ok(wanted.to_owned()),
        (None, [only]) => return Ok((*only).to_owned()),
        (_, []) => {
            let problem = format!("there is no {what} topic, expected ROS 2 messages in CDR");
            return Err(RecordingError::Content(problem));
        }
        (Some(wanted), _) => {
            format!("there are the {what} topics {}, but no {wanted}", names.join(", "))
        }
        (None, _) => format!("there are several {what} topics, {}: choose one", names.join(", ")),
    };
    Err(RecordingError::Option { key: option, problem })
}

/// The optics of a depth topic: those next to it, or the only ones. A compressed topic is one level below the
/// image's.
fn camera_topic(cameras: &BTreeMap<String, Intrinsics>, depth_topic: &str) -> Result<String, RecordingError> {
    let folder = |topic: &str| topic.rsplit_once('/').map_or(String::new(), |(folder, _)| folder.to_owned());
    let image = ["/compressedDepth", "/compressed"].iter().find_map(|end| depth_topic.strip_suffix(end));
    let beside_image = folder(image.unwrap_or(depth_topic));
    let beside: Vec<&String> = cameras.keys().filter(|topic| folder(topic) == beside_image).collect();
    let all: Vec<&String> = cameras.keys().collect();
    match (beside.as_slice(), all.as_slice()) {
        ([only], _) | ([], [only]) => Ok((*only).clone()),
        (_, []) => Err(RecordingError::Content(
            "there is no CameraInfo topic, expected ROS 2 messages in CDR".into(),
        )),
        (_, names) => Err(RecordingError::Content(format!(
            "none of the CameraInfo topics, {names:?}, belongs to {depth_topic}"
        ))),
    }
}
