use glam::{DVec3, IVec3};
use rustc_hash::FxHashMap;

/// Numbered points in cubes, for range queries of at most the edge of a cube.
#[derive(Debug)]
pub(super) struct PointGrid {
    /// Edge of a cube, metres.
    edge: f64,
    cubes: FxHashMap<IVec3, Vec<(u32, DVec3)>>,
}

impl PointGrid {
    pub fn new(edge: f64) -> Self {
        Self { edge, cubes: FxHashMap::default() }
    }

    pub fn insert(&mut self, number: u32, point: DVec3) {
        self.cubes.entry(self.key(point)).or_default().push((number, point));
    }

    /// Returns the points within a radius, which must be at most the edge of a cube. Their order depends only
    /// on their positions and the order of insertion.
    pub fn within(&self, center: DVec3, radius: f64) -> impl Iterator<Item = u32> + '_ {
        let key = self.key(center);
        let side = || -1..=1;
        let around =
            side().flat_map(move |z| side().flat_map(move |y| side().map(move |x| IVec3::new(x, y, z))));
        let points = around.filter_map(move |step| self.cubes.get(&(key + step))).flatten();
        let is_near = move |point: &DVec3| point.distance_squared(center) <= radius * radius;
        points.filter(move |(_, point)| is_near(point)).map(|(number, _)| *number)
    }

    fn key(&self, point: DVec3) -> IVec3 {
        (point / self.edge).floor().as_ivec3()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::random::Random;

    /// The slow twin: all points.
    #[test]
    fn finds_all_points_within_the_distance() {
        let mut random = Random::new(6, 0);
        let points: Vec<DVec3> = (0..500).map(|_| random.in_cube() * 0.1).collect();
        let mut grid = PointGrid::new(0.03);
        (0..).zip(&points).for_each(|(number, point)| grid.insert(number, *point));
        for radius in [0.0, 0.01, 0.03] {
            for center in &points {
                let mut found: Vec<u32> = grid.within(*center, radius).collect();
                found.sort_unstable();
                let is_near = |number: &u32| points[*number as usize].distance(*center) <= radius;
                assert_eq!(found, (0..500).filter(is_near).collect::<Vec<_>>());
            }
        }
    }
}
