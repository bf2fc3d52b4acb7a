//! Finds the measured points of an object of unknown size and place.

use super::table::ShownTable;
use crate::geometry::{Aabb, Lattice};
use crate::sensor::Frame;
use glam::{DVec2, DVec3, IVec3};
use rustc_hash::{FxHashMap, FxHashSet};

/// Edge of the cells in which points are pooled, in voxels.
const CELL_IN_VOXELS: f64 = 2.0;

/// Minimum number of points of an object.
const LEAST_POINTS: usize = 20;

/// Factor on the distance of things that do not reach into the middle of the first image. A wall in the
/// middle is usually more than twice as far as the object beside it, and anything nearer at the image's edge
/// is usually the robot.
const BESIDE_THE_MIDDLE: f64 = 2.0;

/// The points of all frames that are not the table's, pooled in cells; and the object among them: the cells
/// connected, by faces, edges or corners, to those that were the object in the first frame that shows one.
///
/// That first object is the nearest thing of at least 20 points, where something that does not reach into the
/// middle half of the image counts as twice as far.
#[derive(Debug)]
pub(super) struct ObjectPoints {
    lattice: Lattice,
    /// The box around the points of every cell that holds one.
    cells: FxHashMap<IVec3, Aabb>,
    object: FxHashSet<IVec3>,
}

/// Connected cells, and their place in the first image.
#[derive(Default)]
struct Thing {
    cells: FxHashSet<IVec3>,
    n_points: usize,
    /// Smallest depth, and whether a point is in the middle half of the image.
    nearest: f64,
    is_in_the_middle: bool,
}

impl ObjectPoints {
    /// No points yet, for voxels of a valid size (metres).
    pub fn new(voxel_size: f64) -> Self {
        let lattice = Lattice::new(CELL_IN_VOXELS * voxel_size).expect("the session checked the voxel size");
        Self { lattice, cells: FxHashMap::default(), object: FxHashSet::default() }
    }

    /// Adds the points of a frame.
    pub fn add(&mut self, frame: &Frame, table: Option<ShownTable>) {
        let points: Vec<DVec3> = surface_points(frame, table).collect();
        for &point in &points {
            let cell = self.cells.entry(self.lattice.key(point)).or_insert(Aabb { min: point, max: point });
            *cell = Aabb { min: cell.min.min(point), max: cell.max.max(point) };
        }
        let start = match self.object.is_empty() {
            true => self.first_object(frame, &points),
            false => std::mem::take(&mut self.object),
        };
        self.object = self.connected(start);
    }

    /// The box around the object's points; none before there is an object.
    pub fn bounds(&self) -> Option<Aabb> {
        // The box does not depend on the order of the cells.
        Aabb::around(self.object.iter().flat_map(|key| {
            let cell = &self.cells[key];
            [cell.min, cell.max]
        }))
    }

    /// All cells connected to these.
    fn connected(&self, start: FxHashSet<IVec3>) -> FxHashSet<IVec3> {
        let mut open: Vec<IVec3> = start.iter().copied().collect();
        let mut found = start;
        while let Some(cell) = open.pop() {
            let fresh = around(cell).filter(|key| self.cells.contains_key(key));
            open.extend(fresh.filter(|key| found.insert(*key)));
        }
        found
    }

    /// The cells of the frame's points that are the object; none if no thing is large enough.
    fn first_object(&self, frame: &Frame, points: &[DVec3]) -> FxHashSet<IVec3> {
        let things = self.things(frame, points);
        let distance =
            |thing: &Thing| thing.nearest * if thing.is_in_the_middle { 1.0 } else { BESIDE_THE_MIDDLE };
        let large = things.into_iter().filter(|thing| thing.n_points >= LEAST_POINTS);
        let object = large.min_by(|a, b| distance(a).total_cmp(&distance(b)));
        object.map(|thing| thing.cells).unwrap_or_default()
    }

    /// The things that the points (of this frame) form, in the order of their first points.
    fn things(&self, frame: &Frame, points: &[DVec3]) -> Vec<Thing> {
        let camera_from_world = frame.world_from_camera().inverse();
        let (mut things, mut thing_of): (Vec<Thing>, FxHashMap<IVec3, usize>) = Default::default();
        for &point in points {
            let key = self.lattice.key(point);
            let idx = *thing_of.entry(key).or_insert(things.len());
            if idx == things.len() {
                let cells = self.connected(FxHashSet::from_iter([key]));
                things.push(Thing { cells, nearest: f64::INFINITY, ..Thing::default() });
                thing_of.extend(things[idx].cells.iter().map(|cell| (*cell, idx)));
            }
            let in_camera = camera_from_world.transform_point(point);
            let thing = &mut things[idx];
            thing.n_points += 1;
            thing.nearest = thing.nearest.min(in_camera.z);
            thing.is_in_the_middle |= is_in_the_middle(frame, in_camera);
        }
        things
    }
}

/// The points of a frame that are not the table's.
fn surface_points(frame: &Frame, table: Option<ShownTable>) -> impl Iterator<Item = DVec3> + '_ {
    frame.points().filter(move |point| table.is_none_or(|table| table.is_below(*point)))
}

fn is_in_the_middle(frame: &Frame, point_in_camera: DVec3) -> bool {
    let size = DVec2::new(frame.image().width() as f64, frame.image().height() as f64);
    let middle = 0.5 * (size - 1.0);
    let pixel = frame.intrinsics().project(point_in_camera);
    pixel.is_some_and(|pixel| (pixel - middle).abs().cmple(0.25 * size).all())
}

/// The 26 cells around a cell.
fn around(cell: IVec3) -> impl Iterator<Item = IVec3> {
    let offsets = (0..27).filter(|&i| i != 13).map(|i| IVec3::new(i % 3, i / 3 % 3, i / 9) - 1);
    offsets.map(move |offset| cell.saturating_add(offset))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sensor::{DepthImage, Intrinsics};
    use crate::session::Table;
    use crate::view::look_at;

    const VOXEL_SIZE: f64 = 0.01;

    /// The frame of a camera 1 m above the origin that looks down on flat things, whose height is given by
    /// column and row of the image, in steps of 1 cm; 0 is the ground.
    fn frame(height: impl Fn(i32, i32) -> f64) -> Frame {
        let optics = Intrinsics::pinhole(200, 200, DVec2::splat(100.0), DVec2::splat(99.5)).unwrap();
        let depth = (0..40_000).map(|i| (1.0 - height(i % 200 - 100, i / 200 - 100)) as f32).collect();
        let image = DepthImage::from_metres(200, 200, depth).unwrap();
        Frame::new(image, optics, look_at(DVec3::Z, DVec3::ZERO), 3.0).unwrap()
    }

    fn square(u: i32, v: i32, at: (i32, i32), half: i32) -> bool {
        (u - at.0).abs() <= half && (v - at.1).abs() <= half
    }

    fn bounds(frames: &[Frame], table: Table) -> Option<Aabb> {
        let mut points = ObjectPoints::new(VOXEL_SIZE);
        frames.iter().for_each(|frame| {
            points.add(frame, table.find(frames).map(|table| ShownTable::new(table, frame)))
        });
        points.bounds()
    }

    /// Pixels to metres at this height.
    fn half(pixels: f64, height: f64) -> f64 {
        (pixels + 0.5) * 0.01 * (1.0 - height)
    }

    #[test]
    fn the_object_is_the_nearest_thing_and_neither_clutter_nor_ground() {
        for table in [Table::None, Table::AtHeight(0.0), Table::Fitted] {
            let scene = frame(|u, v| match () {
                _ if square(u, v, (0, 0), 10) => 0.3,
                _ if square(u, v, (80, 0), 5) => 0.4,
                _ => 0.0,
            });
            let bounds = bounds(&[scene], table).unwrap();
            assert!((bounds.min.z - 0.3).abs() < 1e-6 && (bounds.max.z - 0.3).abs() < 1e-6, "{bounds:?}");
            assert!((bounds.size().x - 2.0 * half(10.0, 0.3)).abs() < 0.02, "{bounds:?}");
        }
    }

    #[test]
    fn an_object_beside_the_middle_is_nearer_than_the_wall() {
        let scene = frame(|u, v| if square(u, v, (70, 70), 10) { 0.6 } else { 0.0 });
        let bounds = bounds(&[scene], Table::None).unwrap();
        assert!(bounds.min.z > 0.5 && bounds.center().x.abs() > 0.2, "{bounds:?}");
    }

    #[test]
    fn later_frames_add_what_hangs_together() {
        let small = || frame(|u, v| if square(u, v, (0, 0), 10) { 0.3 } else { 0.0 });
        let apart = frame(|u, v| if square(u, v, (60, 0), 10) { 0.3 } else { 0.0 });
        let bridge = frame(|u, v| if square(u, v, (30, 0), 30) { 0.3 } else { 0.0 });
        let table = Table::AtHeight(0.0);
        let first = bounds(&[small()], table).unwrap();
        assert_eq!(bounds(&[small(), apart.clone()], table).unwrap(), first);
        let both = bounds(&[small(), apart, bridge], table).unwrap();
        assert!(both.size().x > 2.5 * first.size().x, "{both:?}");
    }

    #[test]
    fn a_few_points_or_only_the_table_are_no_object() {
        assert_eq!(bounds(&[frame(|_, _| 0.0)], Table::AtHeight(0.0)), None);
        assert_eq!(bounds(&[frame(|_, _| 0.001)], Table::AtHeight(0.0)), None);
        assert_eq!(bounds(&[frame(|_, _| f64::NEG_INFINITY)], Table::None), None);
        let speck = frame(|u, v| if square(u, v, (0, 0), 1) { 0.3 } else { 0.0 });
        assert_eq!(bounds(&[speck], Table::AtHeight(0.0)), None);
    }
}
