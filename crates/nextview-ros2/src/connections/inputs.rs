use super::connector::{Connector, reliable, sensor_data};
use crate::messages::{CameraInfo, CompressedImage, Image, PoseStamped, TfMessage};
use futures_util::StreamExt;
use futures_util::stream::{LocalBoxStream, SelectAll, select_all};
use ros2_client::dds::Subscription;
use ros2_client::qos::Durability;

/// An incoming message.
pub enum Message {
    Image(Image),
    Compressed(CompressedImage),
    Info(CameraInfo),
    Transforms {
        message: TfMessage,
        is_static: bool,
    },
    Pose(PoseStamped),
    /// An unreadable message of this topic, and why.
    Unreadable(&'static str, String),
}

/// The subscribed topics.
pub struct Inputs {
    image: Subscription<Image>,
    compressed: Subscription<CompressedImage>,
    info: Subscription<CameraInfo>,
    poses: Poses,
}

enum Poses {
    /// Subscriptions, each with whether its frames are static.
    Transforms(Vec<(bool, Subscription<TfMessage>)>),
    Topic(Box<Subscription<PoseStamped>>),
}

/// Maximum number of unread transforms: enough for one second of a robot with many joints.
const TRANSFORMS: usize = 200;

impl Inputs {
    pub fn connect(connector: &mut Connector<'_>, use_tf_transforms: bool) -> Result<Self, String> {
        let tf = ("tf2_msgs", "TFMessage");
        let poses = match use_tf_transforms {
            true => {
                let latched = reliable(TRANSFORMS).durability(Durability::TransientLocal);
                Poses::Transforms(vec![
                    (false, connector.subscription("/tf", tf, reliable(TRANSFORMS))?),
                    (true, connector.subscription("/tf_static", tf, latched)?),
                ])
            }
            false => {
                let poses =
                    connector.subscription("pose", ("geometry_msgs", "PoseStamped"), sensor_data())?;
                Poses::Topic(Box::new(poses))
            }
        };
        Ok(Self {
            image: connector.subscription("depth/image", ("sensor_msgs", "Image"), sensor_data())?,
            compressed: connector.subscription(
                "depth/image/compressedDepth",
                ("sensor_msgs", "CompressedImage"),
                sensor_data(),
            )?,
            info: connector.subscription(
                "depth/camera_info",
                ("sensor_msgs", "CameraInfo"),
                sensor_data(),
            )?,
            poses,
        })
    }

    /// All messages in order of arrival.
    pub fn messages(&self) -> SelectAll<LocalBoxStream<'_, Message>> {
        let mut streams = vec![
            stream("depth/image", &self.image, Message::Image),
            stream("depth/image/compressedDepth", &self.compressed, Message::Compressed),
            stream("depth/camera_info", &self.info, Message::Info),
        ];
        match &self.poses {
            Poses::Topic(poses) => streams.push(stream("pose", poses, Message::Pose)),
            Poses::Transforms(topics) => streams.extend(topics.iter().map(|(is_static, transforms)| {
                let topic = if *is_static { "/tf_static" } else { "/tf" };
                stream(topic, transforms, |message| Message::Transforms { message, is_static: *is_static })
            })),
        }
        select_all(streams)
    }
}

fn stream<'a, M: serde::de::DeserializeOwned + 'static>(
    topic: &'static str,
    subscription: &'a Subscription<M>,
    message: impl Fn(M) -> Message + 'a,
) -> LocalBoxStream<'a, Message> {
    let read = subscription.async_stream().map(move |read| match read {
        Ok((content, _)) => message(content),
        Err(error) => Message::Unreadable(topic, format!("{error:?}")),
    });
    read.boxed_local()
}
