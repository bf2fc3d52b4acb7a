use super::location::Location;
use super::object_box::ObjectBox;
use super::object_points::ObjectPoints;
use super::planning_box::growing_box;
use super::scan_map::Place;
use super::table::{ShownTable, Table};
use crate::geometry::Aabb;
use crate::sensor::Frame;

/// Finds the place of the object, frame by frame.
#[derive(Debug)]
pub(super) struct Locator {
    object_box: ObjectBox,
    table: Table,
    voxel_size: f64,
    points: ObjectPoints,
}

impl Locator {
    /// For checked parameters; the voxel size in metres.
    pub fn new(object_box: ObjectBox, table: Table, voxel_size: f64) -> Self {
        Self { object_box, table, voxel_size, points: ObjectPoints::new(voxel_size) }
    }

    /// The place after these frames, of which the last is new.
    pub fn locate(&mut self, frames: &[Frame]) -> Location {
        let table = self.table.find(frames);
        let (object, bounds) = match self.object_box {
            ObjectBox::Known(bounds) => (Some(bounds), Some(bounds)),
            ObjectBox::Growing => {
                if let Some(frame) = frames.last() {
                    self.points.add(frame, table.map(|table| ShownTable::new(table, frame)));
                }
                let object = self.points.bounds();
                (object, object.map(|object| growing_box(&object, self.voxel_size)))
            }
        };
        let bounds = bounds.map(|bounds| table.map_or(bounds, |table| table.clip(bounds)));
        let size = |object: Aabb| (0.5 * object.longest_side()).max(self.voxel_size);
        Location {
            place: Place { bounds, table },
            object: object.map(|object| (object.center(), size(object))),
        }
    }
}
