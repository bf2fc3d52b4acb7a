//! The neighbours of points within a distance.

use glam::{DVec3, IVec3};
use rustc_hash::FxHashMap;

/// Points by cubes of the distance.
pub(crate) struct Patches<'a> {
    positions: &'a [DVec3],
    radius: f64,
    cells: FxHashMap<IVec3, Vec<u32>>,
}

impl<'a> Patches<'a> {
    /// Of finite points, for a positive distance.
    pub fn new(positions: &'a [DVec3], radius: f64) -> Self {
        let mut cells: FxHashMap<IVec3, Vec<u32>> = FxHashMap::default();
        for (i, position) in positions.iter().enumerate() {
            cells.entry(cell(*position, radius)).or_default().push(i as u32);
        }
        Self { positions, radius, cells }
    }

    /// The points within the distance, itself included, in a fixed order.
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
