use super::new_points::NewPoints;
use super::scan_copy::ScanCopy;
use glam::{DVec3, Vec3};
use nextview::motion::Trajectory;
use nextview::sensor::{ColorImage, DepthImage, Frame};
use nextview_scan::FinishedScan;
use std::collections::BTreeMap;

/// One view of a scan as it looks.
#[derive(Clone, Debug)]
pub struct ViewPicture {
    /// Its depth image; shown as a thumbnail.
    pub depth: DepthImage,
    /// Its colour image, of the same size; none without colours.
    pub color: Option<ColorImage>,
    /// The measured points that no frame in the map before saw, world frame, metres; none if the frame is not
    /// in the map.
    pub points: Vec<Vec3>,
    /// The trajectory from the view before, both ends included, world frame, metres. If empty, a straight
    /// line is drawn.
    pub path: Vec<DVec3>,
}

impl ViewPicture {
    /// The pictures of all views of a scan. Points are distinguished by the cells of its final model; those
    /// outside its box are left out, and without a box there are none.
    pub fn of_scan(scan: &FinishedScan<'_>) -> Vec<Self> {
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

/// The positions along a trajectory; none if it goes nowhere.
fn positions(trajectory: &Trajectory) -> Vec<DVec3> {
    let points = trajectory.waypoints().iter().map(|point| point.world_from_camera.translation());
    if trajectory.length() > 0.0 { points.collect() } else { Vec::new() }
}
