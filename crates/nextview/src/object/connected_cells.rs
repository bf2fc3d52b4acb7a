use crate::geometry::Aabb;
use crate::{Cancel, Cancelled};
use glam::{DVec3, IVec3};
use rustc_hash::{FxHashMap, FxHashSet};

/// Finds connected cells: those that share a face, edge or corner, and those whose points are at most a gap
/// apart.
pub(super) struct ConnectedCells<'a> {
    /// The bounding box of the points in each cell.
    cells: &'a FxHashMap<IVec3, Aabb>,
    /// `None` if only touching cells are connected.
    gaps: Option<Gaps>,
    cancel: &'a Cancel,
}

/// The cells not found so far, in buckets: cells within a gap of a cell are in its bucket or the 26 around
/// it.
struct Gaps {
    /// Metres.
    max_gap: f64,
    /// Edge of a bucket, cells.
    edge: i32,
    buckets: FxHashMap<IVec3, Vec<IVec3>>,
}

impl<'a> ConnectedCells<'a> {
    /// Returns a search for cells of this edge and gaps up to this one, metres; a gap of 0 connects only
    /// touching cells.
    pub fn new(cells: &'a FxHashMap<IVec3, Aabb>, cell_size: f64, max_gap: f64, cancel: &'a Cancel) -> Self {
        let gaps = (max_gap > 0.0).then(|| {
            let edge = (max_gap / cell_size).ceil() as i32 + 1;
            let mut buckets: FxHashMap<IVec3, Vec<IVec3>> = FxHashMap::default();
            cells.keys().for_each(|&cell| buckets.entry(bucket(cell, edge)).or_default().push(cell));
            Gaps { max_gap, edge, buckets }
        });
        Self { cells, gaps, cancel }
    }

    /// Returns all cells connected to these, which must not have been found before.
    pub fn around(&mut self, start: FxHashSet<IVec3>) -> Result<FxHashSet<IVec3>, Cancelled> {
        let mut open: Vec<IVec3> = start.iter().copied().collect();
        let mut found = start;
        while let Some(cell) = open.pop() {
            self.cancel.check()?;
            match &mut self.gaps {
                None => {
                    let fresh = around(cell).filter(|key| self.cells.contains_key(key));
                    open.extend(fresh.filter(|key| found.insert(*key)));
                }
                Some(gaps) => gaps.take(cell, self.cells, |key| {
                    if found.insert(key) {
                        open.push(key);
                    }
                }),
            }
        }
        Ok(found)
    }
}

impl Gaps {
    /// Removes this cell and all cells that touch it or lie within the gap from the buckets.
    fn take(&mut self, cell: IVec3, cells: &FxHashMap<IVec3, Aabb>, mut found: impl FnMut(IVec3)) {
        let (middle, max_gap) = (bucket(cell, self.edge), self.max_gap);
        for key in around(middle).chain([middle]) {
            let Some(bucket) = self.buckets.get_mut(&key) else { continue };
            bucket.retain(|&other| {
                let touches = (other.as_i64vec3() - cell.as_i64vec3()).abs().max_element() <= 1;
                let is_connected = touches || gap(&cells[&cell], &cells[&other]) <= max_gap;
                if is_connected {
                    found(other);
                }
                !is_connected
            });
        }
    }
}

fn bucket(cell: IVec3, edge: i32) -> IVec3 {
    cell.div_euclid(IVec3::splat(edge))
}

/// The 26 cells around a cell.
fn around(cell: IVec3) -> impl Iterator<Item = IVec3> {
    let offsets = (0..27).filter(|&i| i != 13).map(|i| IVec3::new(i % 3, i / 3 % 3, i / 9) - 1);
    offsets.map(move |offset| cell.saturating_add(offset))
}

/// Returns the distance between two boxes, metres; 0 if they overlap.
pub(super) fn gap(a: &Aabb, b: &Aabb) -> f64 {
    (a.min - b.max).max(b.min - a.max).max(DVec3::ZERO).length()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::random::Random;

    fn set(cells: &[IVec3]) -> FxHashSet<IVec3> {
        cells.iter().copied().collect()
    }

    /// The slow twin: adds one cell after another until nothing changes.
    fn slow(cells: &FxHashMap<IVec3, Aabb>, start: IVec3, max_gap: f64) -> FxHashSet<IVec3> {
        let mut found = set(&[start]);
        loop {
            let joins = |key: &&IVec3| {
                !found.contains(*key)
                    && found.iter().any(|other| {
                        (**key - *other).abs().max_element() <= 1
                            || max_gap > 0.0 && gap(&cells[*key], &cells[other]) <= max_gap
                    })
            };
            let fresh: Vec<IVec3> = cells.keys().filter(joins).copied().collect();
            if fresh.is_empty() {
                return found;
            }
            found.extend(fresh);
        }
    }

    #[test]
    fn finds_what_one_cell_after_the_other_finds() {
        let mut random = Random::new(4, 0);
        for max_gap in [0.0, 0.001, 0.013, 0.04] {
            for _ in 0..20 {
                let mut cells = FxHashMap::default();
                for _ in 0..60 {
                    let point = 0.1 * random.in_cube();
                    cells.insert((point / 0.01).floor().as_ivec3(), Aabb { min: point, max: point });
                }
                let never = Cancel::default();
                let mut search = ConnectedCells::new(&cells, 0.01, max_gap, &never);
                let mut rest: FxHashSet<IVec3> = cells.keys().copied().collect();
                while let Some(&start) = rest.iter().next() {
                    let found = search.around(set(&[start])).unwrap();
                    assert_eq!(found, slow(&cells, start, max_gap));
                    rest.retain(|cell| !found.contains(cell));
                }
            }
        }
    }
}
