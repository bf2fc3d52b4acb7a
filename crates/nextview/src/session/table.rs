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
/// them still counts as free. On the table are those up to 2 mm above it, or up to three times the deviation
/// of its points, as frames show it, if that is more. The box ends at the table, and candidates below it are
/// out of reach.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case", remote = "Self")]
#[non_exhaustive]
pub enum Table {
    /// Nothing that the camera sees. The default.
    #[default]
    None,
    /// A horizontal surface at this z, metres, finite. With [registration](crate::registration), it is where
    /// the frames show it, at most as far away as poses may be wrong.
    #[serde(rename = "at-height-m")]
    AtHeight(f64),
    /// The largest surface that the first frame with points shows below the camera and less than 30 degrees
    /// from the horizontal, as that frame shows it that shows it best; where there is none, as without a
    /// table.
    Fitted,
}

/// Points up to this height above a table belong to it, metres: the paper's figure (section V.C).
pub const ON_TABLE: f64 = 0.002;

/// A table's points, as a frame shows them, may lie this many times their own deviation above it, if that is
/// more.
const DEVIATIONS: f64 = 3.0;

/// The same for connections to the object: hardly any point of the table may bridge to the next.
const DEVIATIONS_SHOWN: f64 = 5.0;

/// Another frame shows a table better if its points lie this much closer to a plane: each change makes the
/// map anew.
const BETTER: f64 = 0.6;

/// A table whose points lie this close to a plane, metres, is known well enough.
const GOOD: f64 = 0.5 * ON_TABLE;

/// A frame with fewer points shows nothing: the next one is the first that could show a table.
const LEAST_POINTS: usize = 100;

/// How far above a table's points a camera can stand, metres: most of the height of a small camera.
const CLEARANCE: f64 = 0.02;

/// How far a wrong pose may put the points of a table beside it, metres: a degree at half a metre, and a
/// centimetre and a half.
const POSE_ERROR: f64 = 0.025;

/// Noise of a depth camera, as a share of the distance, at most: points that scatter more are of no plane, as
/// where a table is stated to cut through something.
const LARGEST_NOISE: f64 = 0.01;

/// A table that was found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct KnownTable {
    /// Where it is.
    pub plane: Plane,
    /// The plane above which points are no longer its own.
    pub top: Plane,
}

/// A known table as one frame shows it: where a pose is wrong, the table's points are not where the table is,
/// and far away they are noisier than near.
#[derive(Clone, Copy, Debug)]
pub(super) struct ShownTable {
    camera: DVec3,
    /// Points up to one of these planes belong to the table: as it is known, and as the frame shows it.
    tops: [Plane; 2],
    /// So do points above one by up to this times their squared distance from the camera, less [`ON_TABLE`];
    /// per metre.
    per_distance_sq: f64,
}

impl ShownTable {
    /// As the frame shows it, or, if it does not, as it is known.
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

    /// Whether a point of the frame is above the table.
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

    /// The table, as far as the frames (oldest first) show it.
    #[cfg(test)]
    pub(super) fn find(self, frames: &[Frame], cancel: &Cancel) -> Result<Option<KnownTable>, Cancelled> {
        let mut search = TableSearch::new(self, None);
        search.look(frames, cancel)?;
        Ok(search.known())
    }
}

/// The search for a table, frame by frame: a first view from just above it shows a plane of points that are
/// far away and noisy.
#[derive(Clone, Copy, Debug)]
pub(super) struct TableSearch {
    table: Table,
    /// How far poses may be wrong, metres; none if they are right.
    pose_error: Option<f64>,
    /// Whether no frame has shown anything so far.
    is_first: bool,
    found: Option<PlaneFit>,
}

impl TableSearch {
    /// Before the first frame. `pose_error`: how far poses may be wrong, metres; none if they are right.
    pub fn new(table: Table, pose_error: Option<f64>) -> Self {
        Self { table, pose_error, is_first: true, found: None }
    }

    /// The same before the first frame.
    pub fn anew(&self) -> Self {
        Self::new(self.table, self.pose_error)
    }

    /// Looks at more frames, oldest first; returns whether the table is another one now.
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

    /// The table, as far as it is known.
    pub fn known(&self) -> Option<KnownTable> {
        match self.table {
            Table::None => None,
            Table::AtHeight(z) => {
                let stated = Plane::horizontal(z).ok()?;
                Some(match self.found {
                    None => KnownTable::new(stated),
                    Some(found) if self.pose_error.is_some() => KnownTable::fitted(found),
                    // Where it is need not be learned from the frames, but how noisy its points are.
                    Some(found) => KnownTable::fitted(PlaneFit { plane: stated, ..found }),
                })
            }
            Table::Fitted => self.found.map(KnownTable::fitted),
        }
    }

    /// A table that is stated, and how far from there frames may show it.
    fn stated(&self) -> Option<(Plane, f64)> {
        let Table::AtHeight(z) = self.table else { return None };
        let plane = Plane::horizontal(z).ok()?;
        Some((plane, self.pose_error.unwrap_or(POSE_ERROR)))
    }
}

/// Most of a table's own points.
fn points_of<'a>(fit: &PlaneFit, points: &'a [DVec3]) -> impl Iterator<Item = &'a DVec3> {
    let PlaneFit { plane, deviation } = *fit;
    points.iter().filter(move |point| plane.height(**point).abs() <= deviation.max(ON_TABLE))
}

/// Whether a plane's points scatter no more than the noise of a camera that stands here makes them.
fn is_flat(fit: &PlaneFit, points: &[DVec3], camera: DVec3) -> bool {
    let (n, sum) = points_of(fit, points).fold((0, 0.0), |(n, sum), p| (n + 1, sum + p.distance(camera)));
    n as f64 * fit.deviation <= LARGEST_NOISE * sum
}

impl KnownTable {
    /// One without noise.
    pub fn new(plane: Plane) -> Self {
        Self::with_tolerance(plane, ON_TABLE)
    }

    fn with_tolerance(plane: Plane, tolerance: f64) -> Self {
        Self { plane, top: plane.raised(tolerance) }
    }

    fn fitted(fit: PlaneFit) -> Self {
        Self::with_tolerance(fit.plane, ON_TABLE.max(DEVIATIONS * fit.deviation))
    }

    /// The plane below which no camera can stand.
    pub fn floor(&self) -> Plane {
        self.top.raised(CLEARANCE)
    }

    /// Whether a camera at this position is clear of the table.
    pub fn is_clear(&self, position: DVec3) -> bool {
        self.top.height(position) >= CLEARANCE
    }

    /// The box without the part below the table's lowest point in it; the box itself if nothing would be
    /// left.
    pub fn clip(&self, bounds: Aabb) -> Aabb {
        let (normal, min, max) = (self.top.normal(), bounds.min.truncate(), bounds.max.truncate());
        let corners = [min, max, DVec2::new(min.x, max.y), DVec2::new(max.x, min.y)];
        let height = |corner: DVec2| -self.top.height(corner.extend(0.0)) / normal.z;
        let lowest = corners.map(height).into_iter().fold(f64::INFINITY, f64::min);
        let z = if lowest < bounds.max.z { lowest.max(bounds.min.z) } else { bounds.min.z };
        Aabb { min: min.extend(z), ..bounds }
    }
}

/// The top of the table in each frame. Where a pose is wrong, or depths are noisier than in the frame that
/// shows the table best, its points are not where it is known to be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TableTops {
    pub(super) table: KnownTable,
    /// The box around the object.
    pub(super) object: Aabb,
}

impl TableTops {
    /// The plane, in world coordinates, above which the points of a frame are no longer the table's. Only
    /// what the frame shows beside the box around the object counts, as the top of a flat part is no table.
    pub fn in_frame(&self, frame: &Frame) -> Plane {
        let Self { table, object: Aabb { min, max } } = self;
        let is_beside = |p: &DVec3| p.x < min.x || p.x > max.x || p.y < min.y || p.y > max.y;
        let points: Vec<DVec3> = frame.points().filter(is_beside).collect();
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
        // A camera that looks straight down from a metre above the ground, in a pose that is a centimetre too
        // high.
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
    fn far_points_of_a_table_are_no_object() {
        // A camera half a metre to two above a table, with the noise of a stereo camera.
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
        // A plate of this thickness and 26 cm, which fills most of the image, on a table at z = 0.
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
            // With table beside its box, and without.
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
