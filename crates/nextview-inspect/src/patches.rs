//! The neighbours of points within a distance.

use glam::{DVec3, IVec3};
use rustc_hash::FxHashMap;

/// Points, indexed by the cell of a cubic grid whose edge is the radius.
pub(crate) struct Patches<'a> {
    positions: &'a [DVec3],
    radius: f64,
    cells: FxHashMap<IVec3, Vec<u32>>,
}

/// Minimum radius that is chosen automatically, metres.
const SMALLEST: f64 = 0.002;

/// Factor between successive radii that are tried.
const GROWTH: f64 = 1.25;

/// Minimum number of points of a meaningful patch.
pub(crate) const FEWEST: usize = 5;

/// Share of the patches that may hold fewer points if the radius is chosen automatically.
const MAY_HOLD_FEWER: f64 = 0.1;

/// Maximum number of patches whose points are counted to choose the radius.
const N_COUNTED: usize = 500;

/// The patch radius for this spacing of points, metres: the smallest one that suits nearly all of them.
pub(crate) fn suitable_radius(positions: &[DVec3]) -> f64 {
    let size = positions.iter().map(|position| position.distance(positions[0])).fold(0.0, f64::max);
    let mut radius = SMALLEST;
    while radius < size {
        let patches = Patches::new(positions, radius);
        let counted = positions.iter().step_by(positions.len().div_ceil(N_COUNTED));
        let mut counts: Vec<usize> = counted.map(|position| patches.around(*position).count()).collect();
        counts.sort_unstable();
        if counts[(MAY_HOLD_FEWER * counts.len() as f64) as usize] >= FEWEST {
            break;
        }
        radius *= GROWTH;
    }
    radius
}

impl<'a> Patches<'a> {
    /// Indexes finite points, for a positive distance.
    pub fn new(positions: &'a [DVec3], radius: f64) -> Self {
        let mut cells: FxHashMap<IVec3, Vec<u32>> = FxHashMap::default();
        for (i, position) in positions.iter().enumerate() {
            cells.entry(cell(*position, radius)).or_default().push(i as u32);
        }
        Self { positions, radius, cells }
    }

    /// Returns the points within the distance, including the point itself, in a fixed order.
    pub fn around(&self, position: DVec3) -> impl Iterator<Item = usize> + '_ {
        let middle = cell(position, self.radius);
        let side = || -1..=1;
        let offsets =
            side().flat_map(move |x| side().flat_map(move |y| side().map(move |z| IVec3::new(x, y, z))));
        let near = offsets.filter_map(move |offset| self.cells.get(&middle.saturating_add(offset))).flatten();
        let is_near =
            move |i: &usize| self.positions[*i].distance_squared(position) <= self.radius * self.radius;
        near.map(|i| *i as usize).filter(is_near)
    }
}

fn cell(position: DVec3, radius: f64) -> IVec3 {
    (position / radius).floor().as_ivec3()
}

#[cfg(test)]
mod tests {
    use super::*;
    use nextview::geometry::random::Random;

    #[test]
    fn a_patch_holds_what_asking_every_point_finds() {
        let mut random = Random::new(2, 0);
        let positions: Vec<DVec3> = (0..500).map(|_| random.in_cube()).collect();
        let patches = Patches::new(&positions, 0.3);
        for from in &positions[..50] {
            let mut found: Vec<usize> = patches.around(*from).collect();
            found.sort_unstable();
            let is_near = |i: &usize| positions[*i].distance(*from) <= 0.3;
            assert_eq!(found, (0..500).filter(is_near).collect::<Vec<_>>());
        }
    }

    #[test]
    fn the_radius_suits_the_distance_of_the_points() {
        let plane = |spacing: f64| -> Vec<DVec3> {
            (0..60 * 60).map(|i| DVec3::new(f64::from(i % 60), f64::from(i / 60), 0.0) * spacing).collect()
        };
        assert_eq!(suitable_radius(&plane(0.0005)), SMALLEST);
        let radius = suitable_radius(&plane(0.0025));
        assert!((0.0025..0.005).contains(&radius), "{radius}");
        assert_eq!(suitable_radius(&[DVec3::ONE]), SMALLEST);
    }
}
