use glam::IVec3;
use nextview::Cancelled;
use nextview::geometry::VoxelBlock;
use nextview::map::{Occupancy, Snapshot, frontier};
use nextview::planner::Situation;
use nextview::visibility::{FreeSpace, RayCaster};
use rayon::prelude::*;

/// Number of frontier voxels that would remain after each of these views if all unknown voxels on its rays
/// turned out to be free. `ray_spacing` is in voxels of the finest size, checked.
pub(super) fn boundaries(
    situation: &Situation<'_>,
    views: &[usize],
    ray_spacing: f64,
) -> Result<Vec<usize>, Cancelled> {
    let snapshot = situation.snapshot();
    let spacing = ray_spacing * (situation.finest_voxel_size() / snapshot.lattice().voxel_size());
    let caster = RayCaster::new(snapshot, situation.intrinsics(), spacing, FreeSpace::Clear)
        .expect("the constructor checked the ray spacing")
        .within(situation.depth_range());
    let rim = Rim::new(snapshot);
    let after = |seen: &mut SeenVoxels, &view: &usize| {
        seen.forget();
        caster.try_cast(&situation.views().pose(view), |ray| {
            ray.crossings.iter().for_each(|crossing| seen.mark(crossing.voxel as usize));
            situation.cancel().check()
        })?;
        Ok(rim.n_frontier_after(seen))
    };
    views.par_iter().map_init(|| SeenVoxels::new(snapshot.block().n_voxels()), after).collect()
}

/// The unknown voxels that touch an occupied one: each that also touches a free one is a frontier voxel.
struct Rim {
    block: VoxelBlock,
    /// Indices, and whether the voxel is already a frontier voxel.
    voxels: Vec<(usize, bool)>,
}

impl Rim {
    fn new(snapshot: &Snapshot) -> Self {
        let (block, occupancy) = (snapshot.block(), snapshot.occupancy());
        let mut is_frontier = vec![false; occupancy.len()];
        frontier(snapshot).into_iter().for_each(|voxel| is_frontier[voxel] = true);
        let is_rim = |&voxel: &usize| {
            occupancy[voxel] == Occupancy::Unknown
                && around(block, voxel).any(|other| occupancy[other] == Occupancy::Occupied)
        };
        let voxels = (0..occupancy.len()).filter(is_rim).map(|voxel| (voxel, is_frontier[voxel])).collect();
        Self { block, voxels }
    }

    fn n_frontier_after(&self, seen: &SeenVoxels) -> usize {
        let remains = |&&(voxel, is_frontier): &&(usize, bool)| {
            let touches_seen = || around(self.block, voxel).any(|other| seen.holds(other));
            !seen.holds(voxel) && (is_frontier || touches_seen())
        };
        self.voxels.iter().filter(remains).count()
    }
}

/// The voxels of the block that share a face, an edge or a corner with this one.
fn around(block: VoxelBlock, voxel: usize) -> impl Iterator<Item = usize> {
    let key = block.key(voxel);
    let offsets = (0..27).filter(|&n| n != 13).map(|n| IVec3::new(n % 3, n / 3 % 3, n / 9) - 1);
    offsets.filter_map(move |offset| block.index(key + offset))
}

/// The voxels that a view sees.
struct SeenVoxels {
    /// By voxel, the number of the last view that saw it.
    view: Vec<u32>,
    n_views: u32,
}

impl SeenVoxels {
    fn new(n_voxels: usize) -> Self {
        Self { view: vec![0; n_voxels], n_views: 0 }
    }

    /// Starts another view.
    fn forget(&mut self) {
        self.n_views += 1;
    }

    fn mark(&mut self, voxel: usize) {
        self.view[voxel] = self.n_views;
    }

    fn holds(&self, voxel: usize) -> bool {
        self.view[voxel] == self.n_views
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{DVec3, UVec3};
    use nextview::Cancel;
    use nextview::geometry::Lattice;
    use nextview::geometry::random::Random;
    use nextview::map::LogOdds;
    use nextview::sensor::Intrinsics;
    use nextview::view::generate;

    fn random_snapshot(seed: u64) -> Snapshot {
        let mut random = Random::new(seed, 0);
        let block = VoxelBlock::new(IVec3::splat(-6), UVec3::new(12, 11, 10)).unwrap();
        let drawn: Vec<usize> = (0..block.n_voxels()).map(|_| random.index(8)).collect();
        let states = [Some(LogOdds(2.0)), Some(LogOdds(-1.0)), Some(LogOdds(-1.0))];
        let state = |key| states.get(drawn[block.index(key).unwrap()]).copied().flatten();
        Snapshot::from_fn(Lattice::new(0.01).unwrap(), block, state)
    }

    /// The literal definition: makes the voxels that the view sees free, and counts the frontier again.
    fn twin(situation: &Situation<'_>, view: usize) -> usize {
        let snapshot = situation.snapshot();
        let sight = FreeSpace::Clear;
        let caster = RayCaster::new(snapshot, situation.intrinsics(), 0.5, sight).unwrap();
        let mut seen = std::collections::BTreeSet::new();
        caster.cast(&situation.views().pose(view), |ray| {
            seen.extend(ray.crossings.iter().map(|crossing| crossing.voxel as usize));
        });
        let block = snapshot.block();
        let after = Snapshot::from_fn(snapshot.lattice(), block, |key| {
            let voxel = block.index(key).unwrap();
            match snapshot.occupancy()[voxel] {
                Occupancy::Occupied => Some(LogOdds(2.0)),
                Occupancy::Unknown if !seen.contains(&voxel) => None,
                _ => Some(LogOdds(-1.0)),
            }
        });
        frontier(&after).len()
    }

    #[test]
    fn is_the_frontier_of_the_map_in_which_all_seen_is_free() {
        let views = generate::fibonacci_sphere(DVec3::ZERO, 0.3, 7).unwrap();
        let (camera, cancel) = (Intrinsics::d435i(), Cancel::default());
        let mut differs = false;
        for seed in 0..5 {
            let snapshot = random_snapshot(seed);
            let situation = Situation::new(&snapshot, &views, &camera, &cancel);
            let all: Vec<usize> = (0..7).rev().collect();
            let boundaries = boundaries(&situation, &all, 0.5).unwrap();
            let twins: Vec<usize> = all.iter().map(|&view| twin(&situation, view)).collect();
            assert_eq!(boundaries, twins);
            differs |= boundaries.iter().any(|&n| n != frontier(&snapshot).len());
        }
        assert!(differs, "no view sees anything");
    }
}
