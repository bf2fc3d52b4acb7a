use super::Reading;
use crate::geometry::{Aabb, Pose};
use crate::sensor::{Depth, Frame};
use glam::{DVec2, DVec3, IVec3};
use rustc_hash::FxHashMap;
use std::ops::RangeInclusive;

/// Maximum number of measured pixels used of a frame.
const SAMPLES: usize = 3000;

/// Edge of the cells in which points of two frames meet, as a share of the median depth.
const CELL: f64 = 0.03;

/// Plausible median depths of the frames of a scan, metres. If depths and positions have different units, one
/// of two readings has depths outside.
const DEPTHS: RangeInclusive<f64> = 0.05..=20.0;

/// Minimum share of a frame's samples inside the box for the frame to show it.
const IN_BOX: f64 = 0.01;

/// A sample of the measured pixels of a frame.
#[derive(Clone, Debug)]
pub(super) struct PixelSample {
    pub world_from_camera: Pose,
    /// The points, in the camera frame.
    pub points: Vec<DVec3>,
    /// Share, 0..=1, of the frame's pixels that were measured.
    pub measured: f64,
}

impl PixelSample {
    /// Takes every n-th of the measured pixels, row by row.
    pub fn new(frame: &Frame) -> Self {
        let (image, intrinsics) = (frame.image(), frame.intrinsics());
        let pixels = || (0..image.height()).flat_map(|v| (0..image.width()).map(move |u| (u, v)));
        let measured = |&(u, v): &(u32, u32)| matches!(image.get(u, v), Depth::Surface(_));
        let n = pixels().filter(measured).count();
        let drawn = pixels().filter(measured).step_by(n.div_ceil(SAMPLES).max(1));
        let point = |(u, v): (u32, u32)| {
            let Depth::Surface(depth) = image.get(u, v) else { return None };
            let ideal = intrinsics.deproject(DVec2::new(u as f64, v as f64))?;
            Some(ideal.extend(1.0) * depth as f64)
        };
        Self {
            world_from_camera: frame.world_from_camera(),
            points: drawn.filter_map(point).collect(),
            measured: n as f64 / intrinsics.n_pixels() as f64,
        }
    }

    /// The points in the world, as given or under another reading.
    pub fn in_world(&self, reading: Option<Reading>) -> impl Iterator<Item = DVec3> + '_ {
        let pose = reading.map_or(self.world_from_camera, |reading| reading.pose(&self.world_from_camera));
        let in_camera = move |point: &DVec3| reading.map_or(*point, |reading| reading.point(*point));
        self.points.iter().map(move |point| pose.transform_point(in_camera(point)))
    }
}

/// How well frames fit together under a reading: the share of points that meet those of another frame, plus
/// the share of frames that show the object's box, if that is known. 0 under another reading with implausible
/// depths.
pub(super) fn fit(frames: &[PixelSample], reading: Option<Reading>, bounds: Option<Aabb>) -> f64 {
    let Some(depth) = median_depth(frames, reading) else { return 0.0 };
    if reading.is_some() && !DEPTHS.contains(&depth) {
        return 0.0;
    }
    let shown = bounds.map_or(0.0, |bounds| {
        let shows = |frame: &&PixelSample| {
            let n_inside = frame.in_world(reading).filter(|point| bounds.contains(*point)).count();
            n_inside as f64 >= IN_BOX * frame.points.len().max(1) as f64
        };
        frames.iter().filter(shows).count() as f64 / frames.len() as f64
    });
    meeting(frames, reading, CELL * depth) + shown
}

/// The median depth of all samples, metres; `None` if there are no samples.
fn median_depth(frames: &[PixelSample], reading: Option<Reading>) -> Option<f64> {
    let depth = |point: &DVec3| reading.map_or(*point, |reading| reading.point(*point)).z;
    let mut depths: Vec<f64> = frames.iter().flat_map(|frame| &frame.points).map(depth).collect();
    let middle = depths.len() / 2;
    (!depths.is_empty()).then(|| *depths.select_nth_unstable_by(middle, f64::total_cmp).1)
}

/// The share, 0..=1, of the points in cells, with this edge in metres, that points of several frames share.
fn meeting(frames: &[PixelSample], reading: Option<Reading>, cell: f64) -> f64 {
    let n: usize = frames.iter().map(|frame| frame.points.len()).sum();
    // The first frame in a cell, the number of points there, and whether another frame was there, too.
    let mut cells: FxHashMap<IVec3, (usize, usize, bool)> = FxHashMap::default();
    for (i, frame) in frames.iter().enumerate() {
        for point in frame.in_world(reading) {
            let (first, n, is_met) = cells.entry((point / cell).floor().as_ivec3()).or_insert((i, 0, false));
            *n += 1;
            *is_met |= *first != i;
        }
    }
    let n_met: usize = cells.values().filter(|(.., is_met)| *is_met).map(|(_, n, _)| n).sum();
    n_met as f64 / n as f64
}
