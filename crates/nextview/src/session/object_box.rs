use super::object_points::ObjectPoints;
use super::scan_map::Place;
use super::table::ShownTable;
use super::{SessionConfig, Table};
use crate::geometry::Aabb;
use crate::sensor::Frame;
use glam::DVec3;
use serde::{Deserialize, Serialize};

/// What is known of the object's place and size.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ObjectBox {
    /// It lies in this box, metres.
    Known(Aabb),
    /// Nothing. The first frame must show some of it: the object is the nearest thing there (a thing that does not reach
    /// into the middle half of the image counts as twice as far), and whatever later frames show that hangs together with
    /// it. The box is the cube around the middle of the points seen so far, a tenth wider than their longest side and
    /// two voxels more on each side, rounded to whole voxels; so it grows as more is seen (the dynamic box of Daudelin & Campbell 2017). What the object
    /// touches belongs to it, unless it is a [`Table`], which may be 25 mm and 3 degrees off in a frame whose pose is wrong.
    Growing,
}

/// Room around the object, as a share of its size and in voxels on each side.
const MARGIN: f64 = 1.1;
const MARGIN_IN_VOXELS: f64 = 2.0;

/// Finds the place of the object, frame by frame.
#[derive(Debug)]
pub(super) struct Locator {
    object_box: ObjectBox,
    table: Table,
    voxel_size: f64,
    points: ObjectPoints,
}

/// What the frames tell of the place.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Location {
    pub place: Place,
    /// Where the object is and half its longest side, metres: what view candidates follow.
    pub object: Option<(DVec3, f64)>,
}

impl Locator {
    /// For a checked configuration.
    pub fn new(config: &SessionConfig) -> Self {
        let SessionConfig { object_box, table, voxel_size, .. } = *config;
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
                (object, object.map(|object| self.with_margin(object)))
            }
        };
        let bounds = bounds.map(|bounds| table.map_or(bounds, |table| table.clip(bounds)));
        let size = |object: Aabb| (0.5 * object.longest_side()).max(self.voxel_size);
        Location {
            place: Place { bounds, table },
            object: object.map(|object| (object.center(), size(object))),
        }
    }

    /// Centre and half-side are whole voxels, so that a box that grows by less stays what it is, and so do its maps.
    fn with_margin(&self, object: Aabb) -> Aabb {
        let voxel = self.voxel_size;
        let half = (MARGIN * 0.5 * object.longest_side() / voxel + MARGIN_IN_VOXELS).ceil();
        Aabb::cube((object.center() / voxel).round() * voxel, half * voxel)
    }
}
