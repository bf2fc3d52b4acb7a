use super::CloudPoint;
use super::normals::fit_normals;
use super::tangent_plane::TangentPlanes;
use crate::checked::{check_range, checked_when_read};
use crate::degrees;
use crate::geometry::{Aabb, Lattice};
use crate::sensor::{Frame, Intrinsics};
use crate::{Cancel, Cancelled, Error};
use glam::{DVec3, IVec3};
use rustc_hash::FxHashMap;
use serde::{Deserialize, Serialize};

/// Required number, quality and angular separation of looks at each part of the surface.
///
/// A frame is a look at a part of the surface if it measured points there, close enough to their normal, with
/// enough pixels per square millimetre, and from a direction different enough from all earlier looks.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields, remote = "Self")]
pub struct LooksGoal {
    /// Number of looks, 1..=20. Default 3.
    pub n: usize,
    /// Largest angle between the line of sight and the normal, above 0 and below 90 degrees; radians, degrees
    /// in files. Default 60 degrees: beyond that, surface is foreshortened to less than half, and many of its
    /// pixels are lost.
    #[serde(rename = "angle_deg", with = "degrees")]
    #[cfg_attr(feature = "schema", schemars(with = "f64"))]
    pub angle: f64,
    /// Minimum number of pixels per square millimetre of the surface, at least 0, for a sharp texture.
    /// Default 0.
    pub points_per_mm2: f64,
    /// Minimum angle between the directions of two looks, 0 to 60 degrees; radians, degrees in files. Default
    /// 10 degrees.
    #[serde(rename = "apart_deg", with = "degrees")]
    #[cfg_attr(feature = "schema", schemars(with = "f64"))]
    pub apart: f64,
}

checked_when_read!(LooksGoal);

impl Default for LooksGoal {
    fn default() -> Self {
        Self { n: 3, angle: 60_f64.to_radians(), points_per_mm2: 0.0, apart: 10_f64.to_radians() }
    }
}

impl LooksGoal {
    /// Fails on the first value out of range.
    pub fn check(&self) -> Result<(), Error> {
        if !(1..=20).contains(&self.n) {
            return Err(Error::invalid("n", self.n, "1 to 20 looks"));
        }
        let angle = degrees::tidy(self.angle);
        if !(angle > 0.0 && angle < 90.0) {
            return Err(Error::invalid("angle_deg", angle, "a number of degrees above 0 and below 90"));
        }
        if !(self.points_per_mm2 >= 0.0 && self.points_per_mm2.is_finite()) {
            return Err(Error::invalid("points_per_mm2", self.points_per_mm2, "a finite number, at least 0"));
        }
        let apart = degrees::tidy(self.apart);
        check_range("apart_deg", apart, 0.0..=60.0, "a number of degrees in 0..=60")
    }
}

/// The looks at the surface in each cell of space.
///
/// Only the first looks, up to the number of the goal, are stored.
#[derive(Clone, Debug)]
pub struct SurfaceLooks {
    lattice: Lattice,
    n: usize,
    /// Cosine of the largest angle from the normal.
    least_cosine: f64,
    /// Minimum number of pixels per square metre.
    least_density: f64,
    /// Directions with a larger cosine are the same look.
    apart_cosine: f64,
    cells: FxHashMap<IVec3, LookCell>,
}

#[derive(Clone, Debug, Default)]
struct LookCell {
    /// Sum of the normals over the frames, towards the side that was seen.
    normal: DVec3,
    /// Unit directions from the middle of the cell to the cameras.
    looks: Vec<DVec3>,
}

/// Number of image rows between two checks for cancellation.
const ROWS: u32 = 64;

impl SurfaceLooks {
    /// Returns the state before the first frame, for cubes with edges of `cell` metres (at least 0.0001).
    pub fn new(cell: f64, goal: LooksGoal) -> Result<Self, Error> {
        goal.check()?;
        Ok(Self {
            lattice: Lattice::new(cell)?,
            n: goal.n,
            least_cosine: goal.angle.cos(),
            least_density: 1e6 * goal.points_per_mm2,
            apart_cosine: goal.apart.cos(),
            cells: FxHashMap::default(),
        })
    }

    /// Adds the looks of a frame at the surface in a box (world coordinates, finite). If cancelled, nothing
    /// is added.
    pub fn add(&mut self, frame: &Frame, bounds: Aabb, cancel: &Cancel) -> Result<(), Cancelled> {
        let pose = frame.world_from_camera();
        for (key, normal) in normals(frame, &self.lattice, bounds, cancel)? {
            let to_camera = pose.translation() - self.lattice.center(key);
            let is_good = self.is_good(to_camera, normal, frame.intrinsics());
            let direction = to_camera.normalize_or_zero();
            // The order of cells does not matter: each is met once.
            let cell = self.cells.entry(key).or_default();
            cell.normal += normal;
            let is_wanted = cell.looks.len() < self.n && is_good;
            if is_wanted && is_apart(&cell.looks, direction, self.apart_cosine) {
                cell.looks.push(direction);
            }
        }
        Ok(())
    }

    /// Returns the number of looks at the cell of a position, at most that of the goal; `None` if nothing was
    /// measured there.
    pub fn n_at(&self, position: DVec3) -> Option<usize> {
        self.cells.get(&self.lattice.key(position)).map(|cell| cell.looks.len())
    }

    /// Whether a camera with these optics at `camera` that sees the cell of a position would add a missing
    /// look.
    pub(crate) fn lacks(&self, position: DVec3, camera: DVec3, intrinsics: &Intrinsics) -> bool {
        let key = self.lattice.key(position);
        let Some(cell) = self.cells.get(&key).filter(|cell| cell.looks.len() < self.n) else { return false };
        let to_camera = camera - self.lattice.center(key);
        self.is_good(to_camera, cell.normal.normalize_or_zero(), intrinsics)
            && is_apart(&cell.looks, to_camera.normalize_or_zero(), self.apart_cosine)
    }

    /// Whether a camera in this direction sees surface with this normal well enough. Away from the middle of
    /// the image, pixels are denser than assumed here.
    fn is_good(&self, to_camera: DVec3, normal: DVec3, intrinsics: &Intrinsics) -> bool {
        let (focal, cosine) = (intrinsics.focal(), to_camera.normalize_or_zero().dot(normal));
        let density = focal.x * focal.y * cosine / to_camera.length_squared();
        cosine >= self.least_cosine && density >= self.least_density
    }

    /// Returns, for each cell with measured surface, in no fixed order, whether it has all looks of the goal.
    pub(crate) fn are_done(&self) -> impl Iterator<Item = bool> + '_ {
        self.cells.values().map(|cell| cell.looks.len() >= self.n)
    }

    /// Whether a cell has all looks of the goal.
    pub(crate) fn is_done(&self, key: IVec3) -> bool {
        self.cells.get(&key).is_some_and(|cell| cell.looks.len() >= self.n)
    }

    /// Forgets all frames.
    pub(crate) fn clear(&mut self) {
        self.cells.clear();
    }

    pub(crate) fn lattice(&self) -> &Lattice {
        &self.lattice
    }
}

/// Whether no look is closer to this direction than the angle of this cosine.
fn is_apart(looks: &[DVec3], direction: DVec3, apart_cosine: f64) -> bool {
    looks.iter().all(|look| look.dot(direction) <= apart_cosine)
}

/// Returns, by cell and in no fixed order, the unit normal of the surface shown by a frame, in the world.
/// Normals of single pixels are off by tens of degrees if depths are noisy, so it is from a plane through the
/// points of the cell and those around it, if there is one.
fn normals(
    frame: &Frame,
    lattice: &Lattice,
    bounds: Aabb,
    cancel: &Cancel,
) -> Result<impl Iterator<Item = (IVec3, DVec3)> + use<>, Cancelled> {
    cancel.check()?;
    let planes = TangentPlanes::new(frame);
    let (width, rotation) = (frame.image().width(), frame.world_from_camera().rotation_matrix());
    let mut sums: FxHashMap<IVec3, (f64, DVec3, DVec3)> = FxHashMap::default();
    for v in 0..frame.image().height() {
        if v % ROWS == 0 {
            cancel.check()?;
        }
        for (u, point) in frame.row_pixels_in(v, bounds) {
            let Some(plane) = planes.at((v * width + u) as usize) else { continue };
            let (n, points, normals) = sums.entry(lattice.key(point)).or_default();
            *n += 1.0;
            *points += point;
            *normals += plane.normal.as_dvec3();
        }
    }
    let keys: Vec<IVec3> = sums.keys().copied().collect();
    let means = sums.into_values().map(|(n, points, normals)| {
        let normal = normals.try_normalize().map(|normal| rotation * normal);
        CloudPoint { normal, ..(points / n).into() }
    });
    let mut means: Vec<CloudPoint> = means.collect();
    match fit_normals(&mut means, lattice.voxel_size(), cancel) {
        Err(Error::Cancelled(cancelled)) => return Err(cancelled),
        fitted => fitted.expect("the size of the cells was checked"),
    }
    Ok(keys.into_iter().zip(means).filter_map(|(key, mean)| Some((key, mean.normal?))))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Pose;
    use crate::sensor::synthetic::ball;
    use glam::DQuat;
    use std::collections::BTreeSet;

    const CELL: f64 = 0.01;

    /// Frames of a ball of 0.1 m from 0.5 m, in directions of these angles about y (degrees).
    fn around(degrees: &[f64]) -> Vec<Frame> {
        let frame = |degrees: &f64| {
            let rotation = DQuat::from_rotation_y(degrees.to_radians());
            ball(Pose::new(rotation, rotation * DVec3::new(0.0, 0.0, -0.5)).unwrap(), 0.1)
        };
        degrees.iter().map(frame).collect()
    }

    fn looks(goal: LooksGoal, frames: &[Frame]) -> SurfaceLooks {
        let mut looks = SurfaceLooks::new(CELL, goal).unwrap();
        for frame in frames {
            looks.add(frame, Aabb::cube(DVec3::ZERO, 0.4), &Cancel::default()).unwrap();
        }
        looks
    }

    /// The slow twin: the number of frames, one after another, that are looks at a cell; `None` if an angle
    /// from the ball's normal is so close to 60 degrees that the cell's extent decides.
    fn n_by_definition(goal: LooksGoal, frames: &[Frame], key: IVec3) -> Option<usize> {
        let lattice = Lattice::new(CELL).unwrap();
        let mut looks: Vec<DVec3> = Vec::new();
        for frame in frames {
            let planes = TangentPlanes::new(frame);
            let width = frame.image().width();
            let is_in_cell =
                |(i, point): (u32, DVec3)| lattice.key(point) == key && planes.at(i as usize).is_some();
            let mut rows = (0..frame.image().height()).flat_map(|v| {
                let pixels = frame.row_pixels_in(v, Aabb::cube(DVec3::ZERO, 0.4));
                pixels.map(move |(u, point)| (v * width + u, point))
            });
            if !rows.any(is_in_cell) {
                continue;
            }
            let direction = frame.world_from_camera().translation() - lattice.center(key);
            let angle = direction.angle_between(lattice.center(key)).to_degrees();
            if (48.0..72.0).contains(&angle) {
                return None;
            }
            if angle <= 60.0 && looks.iter().all(|look| look.angle_between(direction) >= goal.apart) {
                looks.push(direction);
            }
        }
        Some(looks.len().min(goal.n))
    }

    #[test]
    fn are_those_of_the_definition() {
        let frames = around(&[0.0, 3.0, 12.0, 15.0, 40.0, 41.0, 95.0, 180.0, 1.0]);
        for goal in [
            LooksGoal::default(),
            LooksGoal { n: 20, apart: 0.0, ..LooksGoal::default() },
            LooksGoal { n: 2, apart: 0.5, ..LooksGoal::default() },
        ] {
            let looks = looks(goal, &frames);
            let mut found = BTreeSet::new();
            for &key in looks.cells.keys() {
                let n = looks.n_at(looks.lattice().center(key)).unwrap();
                assert_eq!(looks.is_done(key), n == goal.n);
                if let Some(expected) = n_by_definition(goal, &frames, key) {
                    assert_eq!(n, expected, "{key}");
                    found.insert(n);
                }
            }
            assert!(found.len() >= 3, "{found:?}");
        }
    }

    #[test]
    fn near_looks_count_once_and_flat_ones_not() {
        let front = DVec3::new(0.0, 0.0, -0.1);
        let n = |degrees: &[f64]| looks(LooksGoal::default(), &around(degrees)).n_at(front);
        assert_eq!(n(&[0.0]), Some(1));
        assert_eq!(n(&[0.0, 4.0, -4.0]), Some(1));
        assert_eq!(n(&[0.0, 20.0, 4.0]), Some(2));
        assert_eq!(n(&[0.0, 20.0, 40.0, -20.0, -40.0]), Some(3), "no more than wanted");
        assert_eq!(n(&[180.0]), None);
        assert_eq!(n(&[]), None);
    }

    #[test]
    fn a_camera_lacks_where_it_would_add_a_look() {
        let front = DVec3::new(0.0, 0.0, -0.1);
        let at = |degrees: f64| DQuat::from_rotation_y(f64::to_radians(degrees)) * DVec3::new(0.0, 0.0, -0.5);
        let seen = looks(LooksGoal::default(), &around(&[0.0, 20.0]));
        let camera = *around(&[0.0])[0].intrinsics();
        let lacks = |looks: &SurfaceLooks, degrees| looks.lacks(front, at(degrees), &camera);
        assert!(lacks(&seen, -20.0));
        assert!(!lacks(&seen, 5.0), "as before");
        assert!(!lacks(&seen, -65.0), "too flat");
        assert!(!seen.lacks(DVec3::ZERO, at(-20.0), &camera), "nothing was measured there");
        assert!(!lacks(&looks(LooksGoal::default(), &around(&[0.0, 20.0, 40.0])), -20.0), "done");
    }

    /// From 0.4 m, a millimetre is f / 400 pixels wide.
    #[test]
    fn a_look_is_as_steep_and_as_sharp_as_is_asked_for() {
        let front = DVec3::new(0.0, 0.0, -0.1);
        let frames = around(&[0.0]);
        let density = (frames[0].intrinsics().focal().x / 400.0).powi(2);
        let n = |goal, degrees: f64| looks(goal, &around(&[degrees])).n_at(front);
        let sharp = |share: f64| LooksGoal { points_per_mm2: share * density, ..LooksGoal::default() };
        assert_eq!((n(sharp(0.9), 0.0), n(sharp(1.1), 0.0)), (Some(1), Some(0)));
        assert_eq!(n(sharp(0.9), 40.0), Some(0), "it is foreshortened, and farther away");
        let steep = |degrees: f64| LooksGoal { angle: degrees.to_radians(), ..LooksGoal::default() };
        // At the front, a camera 20 degrees around the middle is 25 degrees off the normal.
        assert_eq!((n(steep(32.0), 20.0), n(steep(18.0), 20.0)), (Some(1), Some(0)));
    }

    #[test]
    fn goals_out_of_range_are_refused() {
        for (goal, problem) in [
            (LooksGoal { n: 0, ..LooksGoal::default() }, "n is 0"),
            (LooksGoal { angle: 1.6, ..LooksGoal::default() }, "angle_deg is 91.6"),
            (LooksGoal { points_per_mm2: f64::INFINITY, ..LooksGoal::default() }, "points_per_mm2 is inf"),
            (LooksGoal { n: 21, ..LooksGoal::default() }, "n is 21"),
            (LooksGoal { apart: 1.1, ..LooksGoal::default() }, "apart_deg is 63.02"),
            (LooksGoal { apart: f64::NAN, ..LooksGoal::default() }, "apart_deg is NaN"),
            (LooksGoal { apart: -0.1, ..LooksGoal::default() }, "apart_deg is -5.7"),
        ] {
            let message = goal.check().unwrap_err().to_string();
            assert!(message.starts_with(problem), "{message}");
        }
        assert!(serde_json::from_str::<LooksGoal>(r#"{"n": 0}"#).is_err());
        let goal = LooksGoal { n: 4, apart: 15_f64.to_radians(), ..LooksGoal::default() };
        assert_eq!(
            serde_json::to_string(&goal).unwrap(),
            r#"{"n":4,"angle_deg":60.0,"points_per_mm2":0.0,"apart_deg":15.0}"#
        );
    }
}
