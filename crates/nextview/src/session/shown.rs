use super::SessionConfig;
use crate::geometry::{Aabb, Lattice, Plane, SegmentWalk};
use crate::map::{Integration, Occupancy, OccupancyMap, SensorModel, Snapshot};
use crate::object::{KnownTable, ShownTable};
use crate::placement::ShownObject;
use crate::sensor::{Depth, DepthImage, Frame};
use crate::{Cancel, Cancelled, Error};
use glam::{DVec2, DVec3};
use rayon::prelude::*;

/// Returns the object in a box on a table as shown by these frames, in voxels of this size (metres), to
/// continue [after](super::Session::after) it is turned.
///
/// # Errors
/// If the box or the voxel size is out of range, or it is cancelled.
pub fn shown_object(
    frames: &[Frame],
    bounds: Aabb,
    table: Plane,
    voxel_size: f64,
    cancel: &Cancel,
) -> Result<ShownObject, Error> {
    let lattice = Lattice::new(voxel_size)?;
    let table = KnownTable::new(table);
    let block = SessionConfig::new(voxel_size, bounds).block(&bounds)?;
    let mut map = OccupancyMap::new(lattice, SensorModel::default())?;
    let integration = Integration { region: Some(block), ground: Some(table.top), ..Integration::default() };
    for frame in frames {
        map.integrate_unless(frame, &integration, cancel)?;
    }
    Ok(shown_on(frames, map.snapshot_unless(block, cancel)?, table, cancel)?)
}

/// As [`shown_object`], but from the map of the frames.
pub(super) fn shown_on(
    frames: &[Frame],
    snapshot: Snapshot,
    table: KnownTable,
    cancel: &Cancel,
) -> Result<ShownObject, Cancelled> {
    let cut = |frame: &Frame| object_only(frame, &snapshot, table, cancel);
    let frames = frames.iter().map(cut).collect::<Result<_, _>>()?;
    ShownObject::new(frames, snapshot, table.plane, cancel)
}

/// Returns the frame with only the object's surface, given its box and its table.
///
/// A ray that ended on something else met nothing if all voxels of the box behind it are free: no part of the
/// object is there, however the object is turned. Otherwise it measured nothing.
fn object_only(
    frame: &Frame,
    snapshot: &Snapshot,
    table: KnownTable,
    cancel: &Cancel,
) -> Result<Frame, Cancelled> {
    let cut = Cut {
        frame,
        snapshot,
        bounds: snapshot.lattice().bounds(&snapshot.block()),
        top: table.top,
        table: ShownTable::new(table, frame),
    };
    let (width, height) = (frame.image().width(), frame.image().height());
    let row = |v: u32| {
        cancel.check()?;
        Ok((0..width).map(|u| cut.pixel(u, v).metres()).collect::<Vec<f32>>())
    };
    let rows: Vec<Vec<f32>> = (0..height).into_par_iter().map(row).collect::<Result<_, Cancelled>>()?;
    let image = DepthImage::from_metres(width, height, rows.concat()).expect("as many pixels as before");
    let (intrinsics, pose) = (*frame.intrinsics(), frame.world_from_camera());
    Ok(Frame::new(image, intrinsics, pose, frame.range()).expect("the image is as large as before"))
}

struct Cut<'a> {
    frame: &'a Frame,
    snapshot: &'a Snapshot,
    bounds: Aabb,
    top: Plane,
    table: ShownTable,
}

impl Cut<'_> {
    fn pixel(&self, u: u32, v: u32) -> Depth {
        let reading = self.frame.image().get(u, v);
        let Depth::Surface(depth) = reading else { return reading };
        let ideal = self.frame.intrinsics().deproject(DVec2::new(f64::from(u), f64::from(v)));
        let Some(in_camera) = ideal.map(|ideal| ideal.extend(1.0) * f64::from(depth)) else { return reading };
        let point = self.frame.world_from_camera().transform_point(in_camera);
        // Points within the table's noise belong to the object if the map has them occupied.
        let is_above =
            || self.table.is_below(point) || self.top.height(point) > 0.0 && self.is_occupied(point);
        if self.bounds.contains(point) && is_above() {
            return reading;
        }
        if self.is_free_behind(point) { Depth::Beyond } else { Depth::Missing }
    }

    fn is_occupied(&self, point: DVec3) -> bool {
        let i = self.snapshot.block().index(self.snapshot.lattice().key(point));
        i.is_some_and(|i| self.snapshot.occupancy()[i] == Occupancy::Occupied)
    }

    /// Whether all voxels of the box behind a point, as seen from the camera, are free.
    fn is_free_behind(&self, point: DVec3) -> bool {
        let (lattice, block) = (self.snapshot.lattice(), self.snapshot.block());
        let camera = self.frame.world_from_camera().translation();
        let (from, direction) = (lattice.to_voxels(point), point - camera);
        let Some(mut walk) = SegmentWalk::ray_within(from, direction, block.min(), block.max()) else {
            return true;
        };
        loop {
            let is_free = |i: usize| self.snapshot.occupancy()[i] == Occupancy::Free;
            match block.index(walk.key()) {
                None => return true,
                Some(i) if !is_free(i) => return false,
                Some(_) => (),
            }
            if walk.advance().is_none() {
                return true;
            }
        }
    }
}
