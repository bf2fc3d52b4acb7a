use super::new_points::NewPoints;
use super::scan_copy::ScanCopy;
use glam::{DVec3, Vec3};
use nextview::motion::Trajectory;
use nextview::sensor::{ColorImage, DepthImage, Frame};
use nextview_scan::ScanState;
use std::collections::BTreeMap;

/// A picture of a view of a scan.
#[derive(Clone, Debug)]
pub struct ViewPicture {
    /// The depth image, shown as a thumbnail.
    pub depth: DepthImage,
    /// The colour image, of the same size; `None` if there are no colours.
    pub color: Option<ColorImage>,
    /// The measured points that no earlier mapped frame saw, world frame, metres; empty if the frame is not
    /// in the map.
    pub points: Vec<Vec3>,
    /// The trajectory from the previous view, both ends included, world frame, metres. If empty, a straight
    /// line is drawn.
    pub path: Vec<DVec3>,
}

impl ViewPicture {
    /// Returns the pictures of all views of a scan. Points are distinguished by the cells of its final model;
    /// those outside its box are left out. Without a box there are none.
    pub fn of_scan(scan: &ScanState<'_>) -> Vec<Self> {
        let copy = ScanCopy::of(scan);
        let mut points = NewPoints::default();
        points.update(&copy);
        Self::of_copy(&copy, &points)
    }

    pub(super) fn of_copy(scan: &ScanCopy, points: &NewPoints) -> Vec<Self> {
        let mapped = scan.step_idxs.iter().copied().zip(&scan.frames);
        let set_aside = scan.set_aside.iter().map(|(step_idx, frame)| (*step_idx, frame));
        let frames: BTreeMap<usize, &Frame> = mapped.chain(set_aside).collect();
        let pictures =
            frames.into_iter().zip(&scan.trajectories).map(|((step_idx, frame), trajectory)| Self {
                depth: frame.image().clone(),
                color: scan.colors[step_idx].clone(),
                points: points.of_step(step_idx).to_vec(),
                path: positions(trajectory),
            });
        pictures.collect()
    }
}

/// The positions along a trajectory; empty if it goes nowhere.
fn positions(trajectory: &Trajectory) -> Vec<DVec3> {
    let points = trajectory.waypoints().iter().map(|point| point.world_from_camera.translation());
    if trajectory.length() > 0.0 { points.collect() } else { Vec::new() }
}
