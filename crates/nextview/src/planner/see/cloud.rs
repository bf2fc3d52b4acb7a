use super::grid::PointGrid;
use crate::geometry::{Aabb, Moments};
use crate::sensor::Frame;
use crate::{Cancel, Cancelled};
use glam::DVec3;
use rayon::prelude::*;

/// The measured points in the box, thinned, and the density of each.
#[derive(Debug)]
pub(super) struct DensityCloud {
    /// Relative to the lowest corner of the box, metres, in the order of frames and pixels.
    pub points: Vec<DVec3>,
    /// By point, the place of the camera that saw it first.
    cameras: Vec<DVec3>,
    /// Metres (the paper's r).
    radius: f64,
    grid: PointGrid,
    bounds: Aabb,
}

/// Class of a point by the density around it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum PointClass {
    /// Enough points lie around it.
    Core,
    /// Between core points and sparse ones.
    Frontier,
    /// Neither.
    Outlier,
}

/// Share of the median number of neighbours that a core point needs.
const CORE_SHARE: f64 = 2.0 / 3.0;

/// Minimum number of points, itself included, around a core point.
const LEAST_NEIGHBORS: usize = 3;

impl DensityCloud {
    /// Collects the points of frames in a box, oldest first. A point at most `gap` metres from an earlier one
    /// is left out. Densities count points within `radius` metres, which must be at least the gap.
    pub fn new(
        frames: &[Frame],
        bounds: Aabb,
        gap: f64,
        radius: f64,
        cancel: &Cancel,
    ) -> Result<Self, Cancelled> {
        let local = Aabb { min: DVec3::ZERO, max: bounds.size() };
        let (points, cameras, grid) = (Vec::new(), Vec::new(), PointGrid::new(radius));
        let mut cloud = Self { points, cameras, radius, grid, bounds: local };
        let mut close = PointGrid::new(gap);
        for frame in frames {
            let camera = frame.world_from_camera().translation() - bounds.min;
            for row in 0..frame.image().height() {
                cancel.check()?;
                for point in frame.row_points_in(row, bounds).map(|point| point - bounds.min) {
                    if close.within(point, gap).next().is_none() {
                        let number = cloud.points.len() as u32;
                        close.insert(number, point);
                        cloud.grid.insert(number, point);
                        cloud.points.push(point);
                        cloud.cameras.push(camera);
                    }
                }
            }
        }
        Ok(cloud)
    }

    /// The class of every point.
    pub fn classes(&self, cancel: &Cancel) -> Result<Vec<PointClass>, Cancelled> {
        let n_around = |point: &DVec3| cancel.check().map(|()| self.grid.within(*point, self.radius).count());
        let counts: Vec<usize> = self.points.par_iter().map(n_around).collect::<Result<_, Cancelled>>()?;
        let mut sorted = counts.clone();
        sorted.sort_unstable();
        let median = sorted.get(sorted.len() / 2).copied().unwrap_or(0);
        let least = ((CORE_SHARE * median as f64).ceil() as usize).max(LEAST_NEIGHBORS);
        // All labels follow from the counts, so their order does not matter.
        let class = |(number, point): (usize, &DVec3)| {
            if counts[number] >= least {
                return PointClass::Core;
            }
            let (mut near_core, mut near_sparse) = (false, false);
            for other in self.grid.within(*point, self.radius).filter(|&other| other != number as u32) {
                let is_core = counts[other as usize] >= least;
                near_core |= is_core;
                near_sparse |= !is_core;
            }
            if near_core && near_sparse { PointClass::Frontier } else { PointClass::Outlier }
        };
        cancel.check()?;
        Ok(self.points.par_iter().enumerate().map(class).collect())
    }

    /// The normal of the surface around a point, towards the cameras that first saw the points around it;
    /// `None` for fewer than three points. The point's own camera may have seen it at too flat an angle to
    /// decide.
    pub fn normal(&self, number: usize) -> Option<DVec3> {
        let point = self.points[number];
        let around = || self.grid.within(point, self.radius).map(|other| other as usize);
        let offsets = around().map(|other| self.points[other] - point);
        let moments = offsets.map(Moments::of).fold(Moments::NONE, |sum, next| sum + next);
        let normal = (moments.n >= LEAST_NEIGHBORS as f64).then(|| moments.least_axis())?;
        let toward: DVec3 = around().map(|other| self.cameras[other] - self.points[other]).sum();
        Some(if normal.dot(toward) < 0.0 { -normal } else { normal })
    }

    /// Whether a camera sees a point past all others: no point is within `step` of the line of sight. The
    /// line begins at the distance at which the normal is clear of the surface, at least two steps.
    pub fn is_visible(&self, point: DVec3, normal: DVec3, camera: DVec3, step: f64) -> bool {
        let is_clear = |place: DVec3| self.grid.within(place, step).next().is_none();
        // No point lies outside the box, and a line that has left it does not return.
        let reach = Aabb { min: self.bounds.min - step, max: self.bounds.max + step };
        let is_off = |off: &f64| {
            let place = point + normal * *off;
            !reach.contains(place) || is_clear(place)
        };
        let start = (2..).map(|n| n as f64 * step).find(is_off).unwrap_or(0.0);
        let distance = point.distance(camera);
        let direction = (camera - point) / distance;
        let way = (0..).map(|n| start + n as f64 * step).take_while(|&way| way < distance);
        let mut places = way.map(|way| point + direction * way).take_while(|&place| reach.contains(place));
        places.all(is_clear)
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::geometry::random::Random;
    use crate::sensor::{DepthImage, Intrinsics};
    use crate::view::look_at;
    use glam::DVec2;

    pub const GAP: f64 = 0.004;
    pub const RADIUS: f64 = 0.02;

    /// Images of a ball of 5 cm around the origin from these directions.
    pub fn frames(directions: &[DVec3]) -> Vec<Frame> {
        let camera = Intrinsics::pinhole(160, 120, DVec2::splat(300.0), DVec2::new(79.5, 59.5)).unwrap();
        let of_pixel = |pixel: u32| {
            let pixel = DVec2::new((pixel % 160) as f64, (pixel / 160) as f64);
            let length_sq = camera.deproject(pixel).unwrap().extend(1.0).length_squared();
            let root = 0.4_f64.powi(2) - length_sq * (0.4_f64.powi(2) - 0.05_f64.powi(2));
            if root < 0.0 { f32::INFINITY } else { ((0.4 - root.sqrt()) / length_sq) as f32 }
        };
        let depths: Vec<f32> = (0..160 * 120).map(of_pixel).collect();
        let frame = |direction: &DVec3| {
            let image = DepthImage::from_metres(160, 120, depths.clone()).unwrap();
            Frame::new(image, camera, look_at(direction.normalize() * 0.4, DVec3::ZERO).unwrap(), 1.0)
                .unwrap()
        };
        directions.iter().map(frame).collect()
    }

    fn cloud(directions: &[DVec3]) -> DensityCloud {
        DensityCloud::new(&frames(directions), Aabb::cube(DVec3::ZERO, 0.08), GAP, RADIUS, &Cancel::default())
            .unwrap()
    }

    const ALL_AROUND: [DVec3; 6] = [DVec3::X, DVec3::Y, DVec3::Z, DVec3::NEG_X, DVec3::NEG_Y, DVec3::NEG_Z];

    #[test]
    fn a_point_close_to_an_earlier_one_is_left_out() {
        let frames = frames(&ALL_AROUND[..2]);
        let mut expected: Vec<DVec3> = Vec::new();
        for point in frames.iter().flat_map(|frame| frame.points_in(Aabb::cube(DVec3::ZERO, 0.08))) {
            let point = point + 0.08;
            if expected.iter().all(|other| other.distance(point) > GAP) {
                expected.push(point);
            }
        }
        assert_eq!(cloud(&ALL_AROUND[..2]).points, expected);
    }

    /// The slow twin: all pairs of points.
    #[test]
    fn classes_are_those_of_the_definition() {
        let cloud = cloud(&ALL_AROUND[..3]);
        let n = cloud.points.len();
        let near = |a: usize, b: usize| cloud.points[a].distance(cloud.points[b]) <= RADIUS;
        let counts: Vec<usize> = (0..n).map(|a| (0..n).filter(|&b| near(a, b)).count()).collect();
        let below = |count: usize| counts.iter().filter(|&&other| other < count).count();
        let at_most = |count: usize| counts.iter().filter(|&&other| other <= count).count();
        let median = *counts.iter().find(|&&count| below(count) <= n / 2 && n / 2 < at_most(count)).unwrap();
        let is_core = |a: usize| counts[a] as f64 >= 2.0 / 3.0 * median as f64 && counts[a] >= 3;
        let class = |a: usize| {
            let mut others = (0..n).filter(|&b| b != a && near(a, b));
            let sparse = (0..n).any(|b| b != a && near(a, b) && !is_core(b));
            match is_core(a) {
                true => PointClass::Core,
                false if sparse && others.any(is_core) => PointClass::Frontier,
                false => PointClass::Outlier,
            }
        };
        let classes = cloud.classes(&Cancel::default()).unwrap();
        assert_eq!(classes, (0..n).map(class).collect::<Vec<_>>());
        assert!(classes.contains(&PointClass::Core) && classes.contains(&PointClass::Frontier));
    }

    #[test]
    fn the_frontier_of_a_ball_is_the_rim_of_what_was_seen() {
        let classes = |cloud: &DensityCloud| cloud.classes(&Cancel::default()).unwrap();
        let frontier = |directions: &[DVec3]| {
            let cloud = cloud(directions);
            let is_frontier = |(point, class): (&DVec3, PointClass)| {
                (class == PointClass::Frontier).then_some(*point - 0.08)
            };
            cloud.points.iter().zip(classes(&cloud)).filter_map(is_frontier).collect::<Vec<_>>()
        };
        assert_eq!(frontier(&ALL_AROUND), []);
        let rim = frontier(&[DVec3::X]);
        assert!(rim.len() > 20, "{}", rim.len());
        // From 0.4 m, a ball of 5 cm is seen as far as x = 0.05^2 / 0.4.
        assert!(rim.iter().all(|point| point.x < 0.025), "{rim:?}");
    }

    #[test]
    fn normals_point_out_of_a_ball() {
        let cloud = cloud(&ALL_AROUND);
        for (number, point) in cloud.points.iter().enumerate() {
            let normal = cloud.normal(number).unwrap();
            assert!(normal.dot((*point - 0.08).normalize()) > 0.95, "{normal} at {point}");
        }
    }

    /// The slow twin: no other direction has less of the points' spread along it, and most of the way to the
    /// cameras is on its side.
    #[test]
    fn a_normal_is_the_direction_of_least_spread_towards_the_cameras() {
        let frames = frames(&ALL_AROUND[..3]);
        let cloud = cloud(&ALL_AROUND[..3]);
        let cameras: Vec<DVec3> = frames.iter().map(|f| f.world_from_camera().translation() + 0.08).collect();
        let mut random = Random::new(11, 0);
        for _ in 0..100 {
            let number = random.index(cloud.points.len());
            let is_near = |other: &&DVec3| other.distance(cloud.points[number]) <= RADIUS;
            let around: Vec<DVec3> = cloud.points.iter().filter(is_near).copied().collect();
            let mean = around.iter().sum::<DVec3>() / around.len() as f64;
            let spread = |axis: DVec3| around.iter().map(|p| (*p - mean).dot(axis).powi(2)).sum::<f64>();
            let normal = cloud.normal(number).unwrap();
            let least = spread(normal);
            for _ in 0..200 {
                let other = random.in_cube().normalize();
                assert!(least <= spread(other) + 1e-12, "{normal} has {least}, {other} {}", spread(other));
                let nearby = (normal + 0.02 * other).normalize();
                assert!(least <= spread(nearby) + 1e-12, "{normal} has {least}, {nearby} {}", spread(nearby));
            }
            // The first camera of a point is that of the points of its frame.
            let first_camera = |point: DVec3| {
                let has = |frame: &Frame| frame.points().any(|of| of + 0.08 == point);
                cameras[frames.iter().position(has).unwrap()]
            };
            let toward: DVec3 = around.iter().map(|&point| first_camera(point) - point).sum();
            assert!(normal.dot(toward) > 0.0 && (normal.length() - 1.0).abs() < 1e-9, "{normal} {toward}");
        }
    }

    /// The slow twin: a walk past all points.
    #[test]
    fn a_point_is_visible_past_all_others() {
        let cloud = cloud(&ALL_AROUND[..3]);
        let is_clear = |place: DVec3| cloud.points.iter().all(|point| point.distance(place) > 0.01);
        let mut random = Random::new(7, 0);
        let mut n_visible = 0;
        for _ in 0..300 {
            let number = random.index(cloud.points.len());
            let (point, normal) = (cloud.points[number], cloud.normal(number).unwrap());
            let camera = random.in_cube().normalize() * 0.4 + 0.08;
            let mut n = 2;
            while !is_clear(point + normal * (0.01 * n as f64)) {
                n += 1;
            }
            let mut expected = true;
            let distance = point.distance(camera);
            while 0.01 * (n as f64) < distance {
                expected &= is_clear(point + (camera - point) * (0.01 * n as f64 / distance));
                n += 1;
            }
            assert_eq!(cloud.is_visible(point, normal, camera, 0.01), expected);
            n_visible += expected as usize;
        }
        assert!((50..250).contains(&n_visible), "{n_visible}");
    }
}
