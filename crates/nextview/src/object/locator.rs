use super::location::Location;
use super::object_box::ObjectBox;
use super::object_points::ObjectPoints;
use super::other_body::{OtherBody, other_bodies};
use super::place::Place;
use super::planning_box::{as_deep_as_wide, growing_box};
use super::table::{ShownTable, Table, TableSearch};
use crate::geometry::Aabb;
use crate::sensor::Frame;
use crate::{Cancel, Cancelled};

/// Locates the object, frame by frame.
#[derive(Clone, Debug)]
pub(crate) struct Locator {
    object_box: ObjectBox,
    table: TableSearch,
    voxel_size: f64,
    points: ObjectPoints,
    /// Number of frames of the placement before: they show only the object, without this table.
    n_earlier: usize,
}

impl Locator {
    /// Returns a locator before the first frame: of an object in this box, on this table, in voxels of this
    /// edge (metres). Parts at most `max_gap` metres apart belong to one object. A camera may be up to
    /// `pose_error`, metres, from its pose, if stated.
    pub fn new(
        object_box: ObjectBox,
        table: Table,
        voxel_size: f64,
        max_gap: f64,
        pose_error: Option<f64>,
    ) -> Self {
        let (table, points) = (TableSearch::new(table, pose_error), ObjectPoints::new(voxel_size, max_gap));
        Self { object_box, table, voxel_size, points, n_earlier: 0 }
    }

    /// Returns the locator before the first frame, where this number of frames of the placement before comes
    /// first.
    pub fn after(&self, n_earlier: usize) -> Self {
        Self { table: self.table.anew(), points: self.points.without_points(), n_earlier, ..*self }
    }

    /// Returns the location after these frames, the last of which is new. After cancellation, the locator is
    /// unusable.
    pub fn locate(&mut self, frames: &[Frame], cancel: &Cancel) -> Result<Location, Cancelled> {
        self.locate_with(frames, frames.len().saturating_sub(1), cancel)
    }

    /// Returns the location after these frames, all of which may have moved. After cancellation, the locator
    /// is unusable.
    pub fn locate_anew(&mut self, frames: &[Frame], cancel: &Cancel) -> Result<Location, Cancelled> {
        self.points.clear();
        self.table = self.table.anew();
        self.locate_with(frames, 0, cancel)
    }

    /// Returns the location after these frames; the points of the first `n_known` are known.
    fn locate_with(
        &mut self,
        frames: &[Frame],
        n_known: usize,
        cancel: &Cancel,
    ) -> Result<Location, Cancelled> {
        let of_now = frames.get(n_known.max(self.n_earlier)..).unwrap_or_default();
        let is_other = self.table.look(of_now, cancel)?;
        let table = self.table.known();
        // Points counted as table may belong to the object after all.
        let n_known = if is_other { 0 } else { n_known };
        if is_other {
            self.points.clear();
        }
        let (object, bounds) = match self.object_box {
            ObjectBox::Known(bounds) => (Some(bounds), Some(bounds)),
            ObjectBox::Growing => {
                self.points.add_all(self.with_table(frames, n_known), cancel)?;
                let cameras = frames.iter().map(|frame| frame.world_from_camera().translation());
                let object = self.points.bounds().map(|seen| as_deep_as_wide(&seen, cameras));
                (object, object.map(|object| growing_box(&object, self.voxel_size)))
            }
        };
        let bounds = bounds.map(|bounds| table.map_or(bounds, |table| table.clip(bounds)));
        let size = |object: Aabb| (0.5 * object.longest_side()).max(self.voxel_size);
        Ok(Location {
            place: Place { bounds, table },
            object: object.map(|object| (object.center(), size(object))),
            may_grow: self.may_grow(frames.len()),
        })
    }

    /// Returns the factor by which an object shown by this number of frames may turn out to be larger.
    fn may_grow(&self, n_frames: usize) -> f64 {
        match self.object_box {
            ObjectBox::Known(_) => 1.0,
            ObjectBox::Growing => 1.0 + MAY_GROW / n_frames.max(1) as f64,
        }
    }

    /// Returns the bodies near an object whose box grows, as shown by all these frames; empty if the box is
    /// known. The frames may have moved since they were located.
    pub fn other_bodies(&self, frames: &[Frame], cancel: &Cancel) -> Result<Vec<OtherBody>, Cancelled> {
        match self.object_box {
            ObjectBox::Known(_) => Ok(Vec::new()),
            ObjectBox::Growing => {
                let mut points = self.points.without_points();
                points.add_all(self.with_table(frames, 0), cancel)?;
                let of_now = frames.get(self.n_earlier..).unwrap_or_default();
                other_bodies(&points, of_now, self.table.known(), cancel)
            }
        }
    }

    /// The frames but the first `n_known`, with the table as each shows it; those of the placement before
    /// show none.
    fn with_table<'a>(
        &self,
        frames: &'a [Frame],
        n_known: usize,
    ) -> impl Iterator<Item = (&'a Frame, Option<ShownTable>)> + use<'a> {
        let (table, n_earlier) = (self.table.known(), self.n_earlier);
        frames.iter().enumerate().skip(n_known).map(move |(i, frame)| {
            let table = table.filter(|_| i >= n_earlier);
            (frame, table.map(|table| ShownTable::new(table, frame)))
        })
    }
}

/// Share of its size by which an object shown by a single frame may turn out to be larger: half of it was not
/// seen, so both its centre and its size are uncertain.
const MAY_GROW: f64 = 0.5;
