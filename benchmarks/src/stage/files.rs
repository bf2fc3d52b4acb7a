use super::Stage;
use crate::workload::{N_IMAGES, Set, Workload};
use nextview::map::Octree;
use std::hint::black_box;

/// Reading and writing the map in OctoMap's formats, to and from memory.
pub(super) fn stages() -> Vec<Stage> {
    let octree = |workload: &Workload| -> Octree {
        workload.map(Set::A, 0.005, N_IMAGES).to_octree().expect("a map of few voxels").pruned()
    };
    let written = move |workload: &Workload, is_full: bool| {
        let mut bytes = Vec::new();
        let tree = octree(workload);
        _ = if is_full { tree.write_ot(&mut bytes) } else { tree.write_bt(&mut bytes) };
        bytes
    };
    vec![
        Stage::new("write .ot", "5 mm", 1, move |workload| {
            let tree = octree(workload);
            Box::new(move || _ = black_box(tree.write_ot(&mut Vec::new())))
        }),
        Stage::new("read .ot", "5 mm", 1, move |workload| {
            let bytes = written(workload, true);
            Box::new(move || _ = black_box(Octree::read(bytes.as_slice())))
        }),
        Stage::new("write .bt", "5 mm", 1, move |workload| {
            let tree = octree(workload);
            Box::new(move || _ = black_box(tree.write_bt(&mut Vec::new())))
        }),
        Stage::new("read .bt", "5 mm", 1, move |workload| {
            let bytes = written(workload, false);
            Box::new(move || _ = black_box(Octree::read(bytes.as_slice())))
        }),
    ]
}
