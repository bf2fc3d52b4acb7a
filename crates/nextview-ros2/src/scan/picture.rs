//! A scan as messages.

use super::{cloud, markers, octomap};
use crate::connections::OutgoingMessage;
use crate::messages::{
    Duration, Header, JointTrajectory, JointTrajectoryPoint, Path, Pose, PoseArray, PoseStamped, Time,
};
use glam::DVec3;
use nextview::session::NextView;
use nextview::surface::downsample;
use nextview_scan::{Fault, LiveScan};

/// All messages after a decision, in this frame. When the scan is over, there is no next view, and its path
/// is empty.
pub fn outputs(scan: &LiveScan, next: Option<&NextView>, frame: &str) -> Result<Vec<OutgoingMessage>, Fault> {
    let session = &scan.scan().session;
    let stamped =
        |stamp: Time, pose: Pose| PoseStamped { header: Header { stamp, ..Header::of(frame) }, pose };
    let mut outputs = Vec::new();
    let mut waypoints = Vec::new();
    if let Some(next) = next {
        outputs.push(OutgoingMessage::NextView(stamped(Time::default(), (&next.world_from_camera).into())));
        let trajectory = scan.trajectory_to(next)?;
        // Times are relative to the camera's start.
        let waypoint = |at: &nextview::motion::Waypoint| {
            stamped(Time::from_seconds(at.time), (&at.world_from_camera).into())
        };
        waypoints = trajectory.waypoints().iter().map(waypoint).collect();
        let joints =
            scan.joints_to(next).map(|joints| OutgoingMessage::JointTrajectory(joint_trajectory(joints)));
        outputs.extend(joints);
    }
    outputs.push(OutgoingMessage::Path(Path { header: Header::of(frame), poses: waypoints }));
    let visited = session.visited();
    let free = session.views().poses().iter().enumerate().filter(|(view, _)| !visited.contains(view));
    let poses = free.map(|(_, pose)| pose.into()).collect();
    outputs.push(OutgoingMessage::Candidates(PoseArray { header: Header::of(frame), poses }));
    let [full, binary] = octomap::messages(session.map(), frame)?;
    outputs.extend([OutgoingMessage::OctomapBinary(binary), OutgoingMessage::OctomapFull(full)]);
    outputs.push(OutgoingMessage::Cloud(cloud::message(&points(scan)?, frame)));
    let taken: Vec<DVec3> =
        session.frames().iter().map(|frame| frame.world_from_camera().translation()).collect();
    let pose = next.map(|next| &next.world_from_camera);
    outputs.push(OutgoingMessage::Markers(markers::message(session.bounds(), pose, &taken, frame)));
    Ok(outputs)
}

/// A joint trajectory has no frame and begins on receipt, so its header is empty.
fn joint_trajectory(joints: &nextview_robot::path::JointTrajectory) -> JointTrajectory {
    let point = |(time, values): &(f64, Vec<f64>)| JointTrajectoryPoint {
        positions: values.clone(),
        time_from_start: Duration::from_seconds(*time),
        ..JointTrajectoryPoint::default()
    };
    let points = joints.points.iter().map(point).collect();
    JointTrajectory { header: Header::default(), joint_names: joints.names.clone(), points }
}

/// The measured points in the box, one per voxel.
fn points(scan: &LiveScan) -> Result<Vec<DVec3>, Fault> {
    let session = &scan.scan().session;
    let Some(bounds) = session.bounds() else { return Ok(Vec::new()) };
    let points = session.frames().iter().flat_map(|frame| frame.points_in(bounds));
    let thinned = downsample(points, session.map().lattice().voxel_size())?;
    Ok(thinned.into_iter().map(|point| point.position).collect())
}
