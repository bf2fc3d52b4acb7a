//! An OctoMap file, `.bt` or `.ot`, and the map in it.

#![no_main]

use libfuzzer_sys::fuzz_target;
use nextview::map::SensorModel;
use nextview_octomap::Octree;

fuzz_target!(|bytes: &[u8]| {
    let Ok(octree) = Octree::read(bytes) else { return };
    let mut written = Vec::new();
    octree.write_ot(&mut written).expect("memory takes it");
    let again = Octree::read(&written[..]).expect("our own file");
    assert_eq!(again.n_leaves(), octree.n_leaves());
    let pruned = octree.pruned();
    let _ = pruned.expanded(1000);
    let _ = octree.to_map(SensorModel::default(), 1000);
});
