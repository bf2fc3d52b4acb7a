use super::connector::Connector;
use crate::messages::{
    JointTrajectory, MarkerArray, Octomap, Path, PointCloud2, PoseArray, PoseStamped, Text,
};
use ros2_client::dds::Publisher;

/// A message to publish.
pub enum OutgoingMessage {
    NextView(PoseStamped),
    Candidates(PoseArray),
    Path(Path),
    JointTrajectory(JointTrajectory),
    OctomapBinary(Octomap),
    OctomapFull(Octomap),
    Cloud(PointCloud2),
    Markers(MarkerArray),
    Status(Text),
}

/// The published topics; late subscribers receive the last message of each.
pub struct Outputs {
    next_view: Publisher<PoseStamped>,
    candidates: Publisher<PoseArray>,
    path: Publisher<Path>,
    joint_trajectory: Publisher<JointTrajectory>,
    octomap_binary: Publisher<Octomap>,
    octomap_full: Publisher<Octomap>,
    cloud: Publisher<PointCloud2>,
    markers: Publisher<MarkerArray>,
    status: Publisher<Text>,
}

impl Outputs {
    pub fn connect(connector: &mut Connector<'_>) -> Result<Self, String> {
        Ok(Self {
            next_view: connector.publisher("~/next_view", ("geometry_msgs", "PoseStamped"))?,
            candidates: connector.publisher("~/candidates", ("geometry_msgs", "PoseArray"))?,
            path: connector.publisher("~/path", ("nav_msgs", "Path"))?,
            joint_trajectory: connector
                .publisher("~/joint_trajectory", ("trajectory_msgs", "JointTrajectory"))?,
            octomap_binary: connector.publisher("~/octomap_binary", ("octomap_msgs", "Octomap"))?,
            octomap_full: connector.publisher("~/octomap_full", ("octomap_msgs", "Octomap"))?,
            cloud: connector.publisher("~/cloud", ("sensor_msgs", "PointCloud2"))?,
            markers: connector.publisher("~/markers", ("visualization_msgs", "MarkerArray"))?,
            status: connector.publisher("~/status", ("std_msgs", "String"))?,
        })
    }

    /// Publishes a message. Fails with the reason.
    pub fn publish(&self, output: OutgoingMessage) -> Result<(), String> {
        match output {
            OutgoingMessage::NextView(message) => sent("~/next_view", self.next_view.publish(message)),
            OutgoingMessage::Candidates(message) => sent("~/candidates", self.candidates.publish(message)),
            OutgoingMessage::Path(message) => sent("~/path", self.path.publish(message)),
            OutgoingMessage::JointTrajectory(message) => {
                sent("~/joint_trajectory", self.joint_trajectory.publish(message))
            }
            OutgoingMessage::OctomapBinary(message) => {
                sent("~/octomap_binary", self.octomap_binary.publish(message))
            }
            OutgoingMessage::OctomapFull(message) => {
                sent("~/octomap_full", self.octomap_full.publish(message))
            }
            OutgoingMessage::Cloud(message) => sent("~/cloud", self.cloud.publish(message)),
            OutgoingMessage::Markers(message) => sent("~/markers", self.markers.publish(message)),
            OutgoingMessage::Status(message) => sent("~/status", self.status.publish(message)),
        }
    }
}

fn sent<M>(topic: &str, result: Result<(), ros2_client::WriteError<M>>) -> Result<(), String> {
    // The error contains the message itself, which may be megabytes.
    result.map_err(|error| match error {
        ros2_client::WriteError::WouldBlock { .. } => {
            format!("{topic}: no subscriber has taken the previous messages")
        }
        _ => format!("{topic}: a message cannot be sent"),
    })
}
