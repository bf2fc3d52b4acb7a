use super::SessionConfig;
use super::location::Location;
use super::object_box::ObjectBox;
use super::object_points::ObjectPoints;
use super::other_body::{OtherBody, other_bodies};
use super::planning_box::{as_deep_as_wide, growing_box};
use super::scan_map::Place;
use super::table::{ShownTable, TableSearch};
use crate::geometry::Aabb;
use crate::registration::RegistrationMode;
use crate::sensor::Frame;
use crate::{Cancel, Cancelled};

/// Finds the place of the object, frame by frame.
#[derive(Clone, Debug)]
pub(super) struct Locator {
    object_box: ObjectBox,
    table: TableSearch,
    voxel_size: f64,
    points: ObjectPoints,
    /// How many of the frames are of the placement before: they show neither this table nor anything else
    /// but the object.
    n_earlier: usize,
}

impl Locator {
    /// For a checked configuration.
    pub fn new(config: &SessionConfig) -> Self {
        let &SessionConfig { object_box, table, registration, voxel_size, max_gap, .. } = config;
        let is_aligned = registration.mode() == RegistrationMode::On;
        let pose_error = is_aligned.then_some(registration.position_uncertainty);
        let (table, points) = (TableSearch::new(table, pose_error), ObjectPoints::new(voxel_size, max_gap));
        Self { object_box, table, voxel_size, points, n_earlier: 0 }
    }

    /// The same before the first frame, where so many frames of the placement before come first.
    pub fn after(&self, n_earlier: usize) -> Self {
        Self { table: self.table.anew(), points: self.points.without_points(), n_earlier, ..*self }
    }

    /// The place after these frames, of which the last is new. The locator is of no use if cancelled.
    pub fn locate(&mut self, frames: &[Frame], cancel: &Cancel) -> Result<Location, Cancelled> {
        self.locate_with(frames, frames.len().saturating_sub(1), cancel)
    }

    /// The place after these frames, all of which may have moved. The locator is of no use if cancelled.
    pub fn locate_anew(&mut self, frames: &[Frame], cancel: &Cancel) -> Result<Location, Cancelled> {
        self.points.clear();
        self.table = self.table.anew();
        self.locate_with(frames, 0, cancel)
    }

    /// The place after these frames, of which the points of the first ones are known.
    fn locate_with(
        &mut self,
        frames: &[Frame],
        n_known: usize,
        cancel: &Cancel,
    ) -> Result<Location, Cancelled> {
        let of_now = frames.get(n_known.max(self.n_earlier)..).unwrap_or_default();
        let is_other = self.table.look(of_now, cancel)?;
        let table = self.table.known();
        // What was taken for the table's may be the object's after all.
        let n_known = if is_other { 0 } else { n_known };
        if is_other {
            self.points.clear();
        }
        let (object, bounds) = match self.object_box {
            ObjectBox::Known(bounds) => (Some(bounds), Some(bounds)),
            ObjectBox::Growing => {
                for (i, frame) in frames.iter().enumerate().skip(n_known) {
                    cancel.check()?;
                    let table = table.filter(|_| i >= self.n_earlier);
                    let table = table.map(|table| ShownTable::new(table, frame));
                    self.points.add(frame, table, cancel)?;
                }
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

    /// By how much an object that so many frames show may turn out to be larger.
    fn may_grow(&self, n_frames: usize) -> f64 {
        match self.object_box {
            ObjectBox::Known(_) => 1.0,
            ObjectBox::Growing => 1.0 + MAY_GROW / n_frames.max(1) as f64,
        }
    }

    /// The bodies beside an object whose box grows; none where the box is known.
    pub fn other_bodies(&self, frames: &[Frame], cancel: &Cancel) -> Result<Vec<OtherBody>, Cancelled> {
        match self.object_box {
            ObjectBox::Known(_) => Ok(Vec::new()),
            ObjectBox::Growing => other_bodies(&self.points, frames, self.table.known(), cancel),
        }
    }
}

/// Share of its size by which an object that a single frame shows may turn out to be larger: half of it was
/// not seen, so both its middle and its size are uncertain.
const MAY_GROW: f64 = 0.5;
