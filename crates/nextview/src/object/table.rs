use crate::Error;
use crate::checked::checked_when_read;
use crate::geometry::{Aabb, Plane, PlaneFit, fit_ground_near, fit_ground_stated, fit_ground_unless};
use crate::sensor::Frame;
use crate::{Cancel, Cancelled};
use glam::{DVec2, DVec3};
use serde::{Deserialize, Serialize};

/// The surface that the object stands on.
///
/// Points on and below the table are not part of the object and make no voxel occupied; the space in front of
/// them still counts as free. Points up to 2 mm above the table, or up to three times the measured deviation
/// of its points if that is more, belong to it. The box ends at the table, and candidates below it are out of
/// reach.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case", remote = "Self")]
#[non_exhaustive]
pub enum Table {
    /// No visible surface. The default.
    #[default]
    None,
    /// A horizontal surface at this z, metres, finite. With [registration](crate::registration), its position
    /// is corrected from the frames, by at most the uncertainty of the poses.
    #[serde(rename = "at-height-m")]
    AtHeight(f64),
    /// The largest surface below the camera, less than 30 degrees from the horizontal, in the first frame
    /// with points, as measured in the frame that shows it best. If there is none, there is no table.
    Fitted,
}

/// Height above a table up to which points belong to it, metres: the paper's value (section V.C).
pub const ON_TABLE: f64 = 0.002;

/// As [`ON_TABLE`], in standard deviations of the table's measured points; the larger of the two counts.
const DEVIATIONS: f64 = 3.0;

/// As [`DEVIATIONS`], but for connections to the object: hardly any point of the table may bridge to the
/// next.
const DEVIATIONS_SHOWN: f64 = 5.0;

/// Another frame shows a table better if it has at most this share of the deviation: each change rebuilds the
/// map.
const BETTER: f64 = 0.6;

/// Deviation of a table's points, metres, at which it is known well enough.
const GOOD: f64 = 0.5 * ON_TABLE;

/// Minimum number of points in a frame that can show a table; frames with fewer are passed over.
const LEAST_POINTS: usize = 100;

/// Minimum height of a camera above a table's points, metres: most of the height of a small camera.
const CLEARANCE: f64 = 0.02;

/// Largest distance of a table's points from the table in a wrong pose, metres: one degree at half a metre,
/// plus a centimetre and a half.
const POSE_ERROR: f64 = 0.025;

/// Maximum noise of a depth camera, as a share of the distance: points that scatter more lie on no plane, as
/// where a configured table cuts through something.
const LARGEST_NOISE: f64 = 0.01;

/// A table with a known plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct KnownTable {
    /// The table's plane.
    pub plane: Plane,
    /// The plane above which points do not belong to it.
    pub top: Plane,
}

/// A known table as measured in one frame: with a wrong pose, its points are not on the table, and far points
/// are noisier than near ones.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ShownTable {
    camera: DVec3,
    /// Points up to one of these planes belong to the table: its known top, and the one measured in the
    /// frame.
    tops: [Plane; 2],
    /// Noise of the table's points per squared distance from the camera, 1/m. A point also belongs to the
    /// table if its height above one of the planes is at most this noise minus [`ON_TABLE`].
    per_distance_sq: f64,
}

impl ShownTable {
    /// Returns the table as measured in the frame, or the known table if the frame does not show it.
    pub fn new(known: KnownTable, frame: &Frame) -> Self {
        let camera = frame.world_from_camera().translation();
        let points: Vec<DVec3> = frame.points().collect();
        let Some(fit) = fit_ground_near(known.plane, POSE_ERROR, &points, camera) else {
            return Self { camera, tops: [known.top; 2], per_distance_sq: 0.0 };
        };
        let (n, sum) =
            points_of(&fit, &points).fold((0, 0.0), |(n, sum), p| (n + 1, sum + p.distance_squared(camera)));
        let per_distance_sq = if n > 0 { DEVIATIONS_SHOWN * fit.deviation * n as f64 / sum } else { 0.0 };
        Self { camera, tops: [known.top, fit.plane.raised(ON_TABLE)], per_distance_sq }
    }

    /// Whether the table is below a point of the frame.
    pub fn is_below(&self, point: DVec3) -> bool {
        let noise = self.per_distance_sq * point.distance_squared(self.camera);
        self.tops.iter().all(|top| top.height(point) > (noise - ON_TABLE).max(0.0))
    }
}

checked_when_read!(Table);

impl Table {
    /// Fails unless the height is finite.
    pub fn check(&self) -> Result<(), Error> {
        match *self {
            Self::AtHeight(z) if !z.is_finite() => {
                Err(Error::invalid("table", z, "a finite height in metres"))
            }
            _ => Ok(()),
        }
    }

    /// Returns the table shown by the frames (oldest first), if any.
    #[cfg(test)]
    pub(crate) fn find(self, frames: &[Frame], cancel: &Cancel) -> Result<Option<KnownTable>, Cancelled> {
        let mut search = TableSearch::new(self, None);
        search.look(frames, cancel)?;
        Ok(search.known())
    }
}

/// The search for a table, frame by frame: a first view from just above it shows only distant, noisy points.
#[derive(Clone, Copy, Debug)]
pub(super) struct TableSearch {
    table: Table,
    /// Largest error of the poses, metres; `None` if they are correct.
    pose_error: Option<f64>,
    /// Whether no frame had enough points so far.
    is_first: bool,
    found: Option<PlaneFit>,
}

impl TableSearch {
    /// Returns the state before the first frame. `pose_error`: largest error of the poses, metres; `None` if
    /// they are correct.
    pub fn new(table: Table, pose_error: Option<f64>) -> Self {
        Self { table, pose_error, is_first: true, found: None }
    }

    /// Returns the search before the first frame.
    pub fn anew(&self) -> Self {
        Self::new(self.table, self.pose_error)
    }

    /// Searches more frames, oldest first. Returns whether the table changed.
    pub fn look(&mut self, frames: &[Frame], cancel: &Cancel) -> Result<bool, Cancelled> {
        let before = self.known();
        if self.table != Table::None {
            for frame in frames {
                cancel.check()?;
                self.look_at(frame, cancel)?;
            }
        }
        Ok(self.known() != before)
    }

    fn look_at(&mut self, frame: &Frame, cancel: &Cancel) -> Result<(), Cancelled> {
        let camera = frame.world_from_camera().translation();
        let points = || frame.points().collect::<Vec<DVec3>>();
        if self.is_first {
            let points = points();
            self.is_first = points.len() < LEAST_POINTS;
            self.found = match self.stated() {
                Some((stated, distance)) => fit_ground_stated(stated, distance, &points, camera)
                    .filter(|found| self.pose_error.is_some() || is_flat(found, &points, camera)),
                None => fit_ground_unless(&points, camera, cancel)?,
            };
        } else if let Some(found) = self.found.filter(|found| found.deviation > GOOD) {
            let shown = fit_ground_near(found.plane, POSE_ERROR, &points(), camera);
            self.found = shown.filter(|shown| shown.deviation < BETTER * found.deviation).or(self.found);
        }
        Ok(())
    }

    /// Returns the table, if known.
    pub fn known(&self) -> Option<KnownTable> {
        match self.table {
            Table::None => None,
            Table::AtHeight(z) => {
                let stated = Plane::horizontal(z).ok()?;
                Some(match self.found {
                    None => KnownTable::new(stated),
                    Some(found) if self.pose_error.is_some() => KnownTable::fitted(found),
                    // Only the noise of its points is learned from the frames, not its height.
                    Some(found) => KnownTable::fitted(PlaneFit { plane: stated, ..found }),
                })
            }
            Table::Fitted => self.found.map(KnownTable::fitted),
        }
    }

    /// Returns the configured table, and the largest distance at which frames may show it.
    fn stated(&self) -> Option<(Plane, f64)> {
        let Table::AtHeight(z) = self.table else { return None };
        let plane = Plane::horizontal(z).ok()?;
        Some((plane, self.pose_error.unwrap_or(POSE_ERROR)))
    }
}

/// Returns most of a table's own points.
fn points_of<'a>(fit: &PlaneFit, points: &'a [DVec3]) -> impl Iterator<Item = &'a DVec3> {
    let PlaneFit { plane, deviation } = *fit;
    points.iter().filter(move |point| plane.height(**point).abs() <= deviation.max(ON_TABLE))
}

/// Whether a plane's points scatter no more than the noise of a camera at this position explains.
fn is_flat(fit: &PlaneFit, points: &[DVec3], camera: DVec3) -> bool {
    let (n, sum) = points_of(fit, points).fold((0, 0.0), |(n, sum), p| (n + 1, sum + p.distance(camera)));
    n as f64 * fit.deviation <= LARGEST_NOISE * sum
}

impl KnownTable {
    /// Returns a table without noise.
    pub fn new(plane: Plane) -> Self {
        Self::with_tolerance(plane, ON_TABLE)
    }

    fn with_tolerance(plane: Plane, tolerance: f64) -> Self {
        Self { plane, top: plane.raised(tolerance) }
    }

    fn fitted(fit: PlaneFit) -> Self {
        Self::with_tolerance(fit.plane, ON_TABLE.max(DEVIATIONS * fit.deviation))
    }

    /// Returns the plane below which no camera can be.
    pub fn floor(&self) -> Plane {
        self.top.raised(CLEARANCE)
    }

    /// Whether a camera at this position is clear of the table.
    pub fn is_clear(&self, position: DVec3) -> bool {
        self.top.height(position) >= CLEARANCE
    }

    /// Returns the box without the part below the table's lowest point in it; the whole box if nothing would
    /// be left.
    pub fn clip(&self, bounds: Aabb) -> Aabb {
        let (normal, min, max) = (self.top.normal(), bounds.min.truncate(), bounds.max.truncate());
        let corners = [min, max, DVec2::new(min.x, max.y), DVec2::new(max.x, min.y)];
        let height = |corner: DVec2| -self.top.height(corner.extend(0.0)) / normal.z;
        let lowest = corners.map(height).into_iter().fold(f64::INFINITY, f64::min);
        let z = if lowest < bounds.max.z { lowest.max(bounds.min.z) } else { bounds.min.z };
        Aabb { min: min.extend(z), ..bounds }
    }
}

/// The top of the table in each frame. If a pose is wrong, or depths are noisier than in the frame that shows
/// the table best, the table's points are not where it is known to be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TableTops {
    pub(super) table: KnownTable,
    /// The object's box.
    pub(super) object: Aabb,
}

impl TableTops {
    /// Returns the plane, in world coordinates, above which the points of a frame do not belong to the table.
    /// Only points next to the object's box count: the top of a flat part is not a table, and a camera that
    /// looks along the table sees a strip of the wall behind it at the same height.
    pub fn in_frame(&self, frame: &Frame) -> Plane {
        let Self { table, object } = self;
        let (min, max) = (object.min.truncate(), object.max.truncate());
        let reach = object.longest_side();
        let is_in = |p: &DVec3, margin: f64| {
            let p = p.truncate();
            p.cmpge(min - margin).all() && p.cmple(max + margin).all()
        };
        let points: Vec<DVec3> = frame.points().filter(|p| is_in(p, reach) && !is_in(p, 0.0)).collect();
        let camera = frame.world_from_camera().translation();
        let fit = fit_ground_stated(table.plane, POSE_ERROR, &points, camera);
        let fit = fit.filter(|fit| is_flat(fit, &points, camera));
        fit.map_or(table.top, |fit| KnownTable::fitted(fit).top)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Pose;
    use crate::geometry::random::Random;
    use crate::sensor::{DepthImage, Intrinsics};
    use crate::view::look_at;

    #[test]
    fn the_box_ends_at_the_top() {
        let table = Table::AtHeight(0.1).find(&[], &Cancel::default()).unwrap().unwrap();
        let clipped = table.clip(Aabb::cube(DVec3::ZERO, 0.5));
        assert!((clipped.min.z - 0.102).abs() < 1e-15 && clipped.min.x == -0.5 && clipped.max.z == 0.5);
        let above = Aabb::cube(DVec3::ONE, 0.5);
        assert_eq!(table.clip(above), above);
        let below = Aabb::cube(-DVec3::ONE, 0.5);
        assert_eq!(table.clip(below), below);
        let tilted =
            KnownTable::with_tolerance(Plane::new(DVec3::new(0.1, 0.0, 1.0), DVec3::ZERO).unwrap(), 0.0);
        assert!((tilted.clip(Aabb::cube(DVec3::ZERO, 0.5)).min.z + 0.05).abs() < 1e-15);
    }

    #[test]
    fn a_stated_table_is_where_frames_show_it_if_their_poses_may_be_wrong() {
        // A camera looking straight down from a metre above the ground, with a pose a centimetre too high.
        let optics = Intrinsics::pinhole(40, 40, DVec2::splat(20.0), DVec2::splat(19.5)).unwrap();
        let image = DepthImage::from_metres(40, 40, vec![1.0; 1600]).unwrap();
        let pose = look_at(DVec3::Z * 1.01, DVec3::ZERO).unwrap();
        let frames = [Frame::new(image, optics, pose, 3.0).unwrap()];
        for (pose_error, z) in [(None, 0.0), (Some(0.05), 0.01), (Some(0.005), 0.0)] {
            let mut search = TableSearch::new(Table::AtHeight(0.0), pose_error);
            search.look(&frames, &Cancel::default()).unwrap();
            let height = search.known().unwrap().plane.height(DVec3::Z * z);
            assert!(height.abs() < 1e-6, "{pose_error:?}: {height}");
        }
    }

    #[test]
    fn a_wall_behind_a_table_seen_from_the_side_is_no_table() {
        // A camera a few centimetres above a table, too flat to measure it, in front of a wall at two metres.
        let optics = Intrinsics::pinhole(160, 120, DVec2::splat(150.0), DVec2::new(79.5, 59.5)).unwrap();
        let image = DepthImage::from_metres(160, 120, vec![2.0; 160 * 120]).unwrap();
        let pose = look_at(DVec3::new(0.25, 0.0, 0.03), DVec3::Z * 0.03).unwrap();
        let frame = Frame::new(image, optics, pose, 4.0).unwrap();
        let table = Table::AtHeight(0.0).find(&[], &Cancel::default()).unwrap().unwrap();
        let object = Aabb { min: DVec3::new(-0.04, -0.04, 0.002), max: DVec3::new(0.04, 0.04, 0.06) };
        assert_eq!(TableTops { table, object }.in_frame(&frame), table.top);
    }

    #[test]
    fn far_points_of_a_table_are_no_object() {
        // A camera half a metre to two from a table, with the noise of a stereo camera.
        let optics = Intrinsics::pinhole(160, 120, DVec2::splat(150.0), DVec2::new(79.5, 59.5)).unwrap();
        for height in [0.3, 0.6, 0.9, 1.2] {
            let mut random = Random::new(1, 0);
            let pose = look_at(DVec3::new(height, 0.0, height), DVec3::ZERO).unwrap();
            let depth = |pixel: usize| {
                let ray = optics.deproject(DVec2::new((pixel % 160) as f64, (pixel / 160) as f64)).unwrap();
                let z = -height / (pose.rotation() * ray.extend(1.0)).z;
                if z > 0.0 { (z + 0.0038 * z * z * random.normal()) as f32 } else { 0.0 }
            };
            let image = DepthImage::from_metres(160, 120, (0..160 * 120).map(depth).collect()).unwrap();
            let frame = Frame::new(image, optics, pose, 4.0).unwrap();
            for table in [Table::Fitted, Table::AtHeight(0.0)] {
                let known = table.find(std::slice::from_ref(&frame), &Cancel::default()).unwrap().unwrap();
                let shown = ShownTable::new(known, &frame);
                let (n, n_above) =
                    (frame.points().count(), frame.points().filter(|p| shown.is_below(*p)).count());
                let n_on_top = frame.points().filter(|p| known.top.height(*p) > 0.0).count();
                assert!(20 * n_on_top < n, "{table:?} from {height} m: {n_on_top} of {n} above its top");
                assert!(
                    n > 10_000 && 2000 * n_above < n,
                    "{table:?} from {height} m: {n_above} of {n} above"
                );
            }
        }
    }

    #[test]
    fn a_table_is_where_a_frame_shows_it_and_no_flat_part_is_a_table() {
        let optics = Intrinsics::pinhole(80, 60, DVec2::splat(75.0), DVec2::new(39.5, 29.5)).unwrap();
        let taken_from = look_at(DVec3::new(0.2, 0.0, 0.3), DVec3::ZERO).unwrap();
        // A plate of this thickness and 26 cm wide, filling most of the image, on a table at z = 0.
        let frame = |thickness: f64, shift: f64| {
            let depth = |pixel: usize| {
                let ray = optics.deproject(DVec2::new((pixel % 80) as f64, (pixel / 80) as f64)).unwrap();
                let direction = taken_from.rotation() * ray.extend(1.0);
                let to = |z: f64| (z - taken_from.translation().z) / direction.z;
                let on_plate = taken_from.translation() + direction * to(thickness);
                let is_plate = thickness > 0.0 && on_plate.truncate().abs().max_element() < 0.13;
                to(if is_plate { thickness } else { 0.0 }) as f32
            };
            let image = DepthImage::from_metres(80, 60, (0..80 * 60).map(depth).collect()).unwrap();
            let pose = Pose::new(taken_from.rotation(), taken_from.translation() + shift * DVec3::Z).unwrap();
            Frame::new(image, optics, pose, 4.0).unwrap()
        };
        let known = KnownTable::new(Plane::horizontal(0.0).unwrap());
        let top = |frame: &Frame, half: f64| {
            TableTops { table: known, object: Aabb::cube(DVec3::ZERO, half) }
                .in_frame(frame)
                .height(DVec3::ZERO)
                + ON_TABLE
        };
        for shift in [-0.02, -0.004, 0.0, 0.005] {
            assert!((top(&frame(0.0, shift), 0.05) + shift).abs() < 1e-5, "{shift}");
        }
        for thickness in [0.003, 0.007, 0.02] {
            let frame = frame(thickness, 0.0);
            let n_plate = frame.points().filter(|point| point.z > 0.5 * thickness).count();
            assert!(2 * n_plate > frame.points().count(), "the plate fills most of the image");
            // With table visible outside its box, and without.
            for half in [0.14, 1.0] {
                assert!(top(&frame, half).abs() < 1e-5, "{thickness}");
            }
        }
    }

    #[test]
    fn cameras_keep_clear() {
        let table = Table::AtHeight(0.0).find(&[], &Cancel::default()).unwrap().unwrap();
        assert!(table.is_clear(DVec3::Z * 0.03) && !table.is_clear(DVec3::Z * 0.01));
        assert_eq!(Table::Fitted.find(&[], &Cancel::default()), Ok(None));
        assert!(Table::AtHeight(f64::NAN).check().is_err());
    }
}
