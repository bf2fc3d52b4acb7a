//! Bounds on scans without a region, whose rays may have any length.

use super::brick::{BRICK_EDGE, CELLS, brick_key};
use super::key_box::KeyBox;
use super::scan::VoxelScan;
use crate::Error;
use crate::geometry::{Lattice, SegmentWalk};
use glam::{DVec3, IVec3};
use rustc_hash::FxHashSet;

/// Maximum number of voxels crossed by the rays of a scan, counted for each ray: some ten seconds.
const MOST_CROSSINGS: f64 = (1_u64 << 33) as f64;

/// Maximum number of bricks that a scan may touch: 4.3 GB.
const MOST_BRICKS: usize = 1 << 21;

/// Maximum number of bricks in a scan's box for which it is not examined further: its rays fill a third of it
/// or less.
const MOST_BRICKS_OF_BOX: f64 = 2.0 * MOST_BRICKS as f64;

impl VoxelScan {
    /// Fails if the scan, with rays that start here, in units of voxels, has points too far away for keys, or
    /// would take too much time or memory.
    pub fn check_size(&self, origin: DVec3) -> Result<(), Error> {
        let reach = Lattice::REACH as f64;
        if let Some(end) = self.ends.iter().find(|end| end.abs().max_element() > reach) {
            let expected = "268,435,456 voxels at most on each axis";
            return Err(Error::invalid("distance of a point from the origin, in voxels", end, expected));
        }
        let crossings: f64 = self.ends.iter().map(|end| (end - origin).abs().element_sum()).sum();
        if crossings > MOST_CROSSINGS {
            let expected = "8.6e9 at most: larger voxels, a shorter range, or a region";
            return Err(Error::invalid("voxels crossed by the rays of a scan", crossings, expected));
        }
        let bricks_of_box = self.reach(origin).map_or(0.0, |keys| n_bricks(&keys));
        let bricks_of_rays = crossings / BRICK_EDGE as f64 + 4.0 * self.ends.len() as f64;
        if bricks_of_box <= MOST_BRICKS_OF_BOX || bricks_of_rays <= MOST_BRICKS as f64 {
            return Ok(());
        }
        self.check_bricks(origin)
    }

    /// Counts the bricks crossed by the rays until there are too many: a single ray may cross a hundred
    /// million.
    fn check_bricks(&self, origin: DVec3) -> Result<(), Error> {
        let mut bricks: FxHashSet<IVec3> = FxHashSet::default();
        let scale = 1.0 / BRICK_EDGE as f64;
        for end in &self.ends {
            let mut walk = SegmentWalk::new(origin * scale, *end * scale);
            bricks.insert(walk.key());
            while walk.advance().is_some() {
                bricks.insert(walk.key());
                if bricks.len() > MOST_BRICKS {
                    let what = format!("a scan of {} rays without a region", self.ends.len());
                    let limit_mb = (MOST_BRICKS * CELLS * size_of::<f32>()) as u64 / 1_000_000;
                    return Err(Error::TooLarge { what, needed_mb: limit_mb + 1, limit_mb });
                }
            }
        }
        Ok(())
    }
}

fn n_bricks(keys: &KeyBox) -> f64 {
    (brick_key(keys.max).as_dvec3() - brick_key(keys.min).as_dvec3() + 1.0).element_product()
}
