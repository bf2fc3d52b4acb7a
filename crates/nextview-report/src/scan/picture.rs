use glam::{DVec3, Vec3};
use nextview::motion::Trajectory;
use nextview::sensor::{ColorImage, DepthImage, Frame};
use nextview_scan::FinishedScan;
use std::collections::{BTreeMap, HashSet};

/// One view of a scan as it looks.
#[derive(Clone, Debug)]
pub struct ViewPicture<'a> {
    /// Its depth image; shown as a thumbnail.
    pub depth: &'a DepthImage,
    /// Its colour image, of the same size; none without colours.
    pub color: Option<ColorImage>,
    /// The measured points that no frame in the map before saw, world frame, metres; none if the frame is not
    /// in the map.
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
        let session = &scan.session;
        let mapped = session.frame_numbers().iter().copied().zip(session.frames());
        let aside = session.set_aside().iter().map(|aside| (aside.number, &aside.frame));
        let frames: BTreeMap<usize, &Frame> = mapped.clone().chain(aside).collect();
        let mut points: BTreeMap<usize, Vec<Vec3>> = BTreeMap::new();
        for (number, frame) in mapped {
            let points_in = bounds.iter().flat_map(|&(bounds, cell_size)| {
                frame.points_in(bounds).map(move |point| ((point / cell_size).floor().as_ivec3(), point))
            });
            let new = points_in.filter(|(cell, _)| known.insert(*cell)).map(|(_, point)| point.as_vec3());
            points.insert(number, new.collect());
        }
        let pictures = frames.into_iter().zip(&scan.trajectories).map(|((number, frame), trajectory)| Self {
            depth: frame.image(),
            // A page without the colours of an image that can no longer be read is better than none.
            color: scan.color(number).ok().flatten(),
            points: points.remove(&number).unwrap_or_default(),
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
