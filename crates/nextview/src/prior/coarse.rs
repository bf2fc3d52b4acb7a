use crate::geometry::{Lattice, VoxelBlock, VoxelKey};
use crate::map::{LogOdds, Occupancy, Snapshot};
use std::borrow::Cow;

/// Longest side of a block, in voxels, that the prior was trained for.
const LONGEST: u32 = 72;

/// The snapshot in voxels so coarse that the prior knows blocks of as many: the snapshot itself if it is coarse enough.
///
/// As when a map is made in larger voxels, one is occupied if a part of it is, else free if a part of it is, else unknown. What the object looks
/// like shows in as few voxels, and the time to plan does not grow with the resolution of the map.
pub fn coarse_enough(snapshot: &Snapshot) -> Cow<'_, Snapshot> {
    let mut coarse = Cow::Borrowed(snapshot);
    while coarse.block().dims().max_element() > LONGEST {
        coarse = Cow::Owned(halved(&coarse));
    }
    coarse
}

/// The same block in voxels twice as large.
fn halved(snapshot: &Snapshot) -> Snapshot {
    let fine = snapshot.block();
    let lattice = Lattice::new(2.0 * snapshot.lattice().voxel_size())
        .expect("larger voxels are allowed where smaller ones are");
    let (low, high): (VoxelKey, VoxelKey) = (fine.min() >> 1, fine.max() >> 1);
    let block = VoxelBlock::new(low, (high - low + 1).as_uvec3()).expect("not smaller than a voxel");
    let mut known = vec![None; block.n_voxels()];
    for (voxel, &state) in snapshot.occupancy().iter().enumerate() {
        let Some(coarse) = block.index(fine.key(voxel) >> 1).filter(|_| state != Occupancy::Unknown) else {
            continue;
        };
        let probability = snapshot.probability()[voxel];
        let most = known[coarse].get_or_insert(probability);
        *most = probability.max(*most);
    }
    Snapshot::from_fn(lattice, block, |key| {
        let probability = known[block.index(key)?]?;
        Some(LogOdds((probability / (1.0 - probability)).ln()))
    })
}
