//! Maps and trees of any numbers: an error, or a file that reads back to the same tree.

use glam::IVec3;
use nextview::geometry::Lattice;
use nextview::map::{LogOdds, OccupancyMap, SensorModel};
use nextview_octomap::Octree;
use proptest::prelude::*;

/// A few keys around one that may be anywhere.
fn keys() -> impl Strategy<Value = Vec<IVec3>> {
    let near = prop::array::uniform3(-40_000..40_000_i32);
    let around =
        prop_oneof![Just([0; 3]), prop::array::uniform3(any::<i32>()), Just([i32::MIN, 0, i32::MAX])];
    let list = prop::collection::vec(prop_oneof![3 => prop::array::uniform3(-9..9), 1 => near], 0..20);
    (around, list).prop_map(|(around, list)| {
        list.into_iter().map(|key| IVec3::from_array(around).wrapping_add(IVec3::from_array(key))).collect()
    })
}

fn reads_back(tree: &Octree) -> Result<(), TestCaseError> {
    let mut file = Vec::new();
    tree.write_ot(&mut file).expect("memory takes every byte");
    prop_assert_eq!(&Octree::read(&file[..]).expect("what was written is read"), tree);
    Ok(())
}

proptest! {
    #[test]
    fn what_is_written_reads_back(
        keys in keys(),
        value in prop_oneof![3 => -3.0_f32..3.0, 1 => any::<f32>()],
        size in prop_oneof![2 => 1e-4..1e12, 1 => any::<f64>()],
    ) {
        if let Ok(tree) = Octree::from_voxels(size, keys.iter().map(|key| (*key, value))) {
            reads_back(&tree)?;
        }
        let voxels = keys.iter().map(|key| (*key, LogOdds(value)));
        let map = Lattice::new(size).and_then(|it| OccupancyMap::from_voxels(it, SensorModel::default(), voxels));
        if let Ok(tree) = map.and_then(|map| Octree::from_map(&map)) {
            reads_back(&tree)?;
        }
    }
}
