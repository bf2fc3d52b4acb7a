use glam::{DVec3, Vec3};
use nextview::motion::Trajectory;
use nextview::sensor::DepthImage;
use nextview_scan::FinishedScan;
use std::collections::HashSet;

/// One view of a scan as it looks.
#[derive(Clone, Debug)]
pub struct ViewPicture<'a> {
    /// Its depth image; shown as a thumbnail.
    pub depth: &'a DepthImage,
    /// The measured points that no earlier view saw, world frame, metres.
    pub points: Vec<Vec3>,
    /// The trajectory from the view before, both ends included, world frame, metres. If empty, a straight
    /// line is drawn.
    pub path: Vec<DVec3>,
}

impl<'a> ViewPicture<'a> {
    /// The pictures of all views of a scan. Points are distinguished by the cells of its final model; those
    /// outside its box are left out, and without a box there are none.
    pub fn of_scan(scan: &'a FinishedScan<'_>) -> Vec<Self> {
        let mut known = HashSet::new();
        let bounds = scan.bounds().map(|bounds| (bounds, scan.detail(bounds)));
        let pictures = scan.session.frames().iter().zip(&scan.trajectories).map(|(frame, trajectory)| {
            let points = bounds.iter().flat_map(|&(bounds, cell_size)| {
                frame.points_in(bounds).map(move |point| ((point / cell_size).floor().as_ivec3(), point))
            });
            let new = points.filter(|(cell, _)| known.insert(*cell)).map(|(_, point)| point.as_vec3());
            Self { depth: frame.image(), points: new.collect(), path: positions(trajectory) }
        });
        pictures.collect()
    }
}

/// The positions along a trajectory; none if it goes nowhere.
fn positions(trajectory: &Trajectory) -> Vec<DVec3> {
    let points = trajectory.waypoints().iter().map(|point| point.world_from_camera.translation());
    if trajectory.length() > 0.0 { points.collect() } else { Vec::new() }
}
