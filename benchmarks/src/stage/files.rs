use super::timed_stage::Stage;
use crate::workload::{DEPTH_UNIT, N_IMAGES, Set, Workload, intrinsics};
use nextview_model::write_mesh;
use nextview_octomap::Octree;
use nextview_recording::{decode_depth, encode_depth};
use nextview_sim::mesh;
use std::hint::black_box;
use std::path::PathBuf;

/// Reading and writing maps in OctoMap's formats and depth images, to and from memory, and meshes.
pub(super) fn stages() -> Vec<Stage> {
    maps().into_iter().chain(images()).chain(meshes()).collect()
}

fn images() -> [Stage; 2] {
    [
        Stage::new("write depth PNG", "640 x 480", 1, |workload| {
            let image = workload.frames()[0].image().clone();
            Box::new(move || _ = black_box(encode_depth(&image, DEPTH_UNIT)))
        }),
        Stage::new("read depth PNG", "640 x 480", 1, |workload| {
            let bytes = encode_depth(workload.frames()[0].image(), DEPTH_UNIT);
            Box::new(move || _ = black_box(decode_depth(&bytes, None, &intrinsics(), DEPTH_UNIT)))
        }),
    ]
}

fn meshes() -> [Stage; 2] {
    [
        Stage::new("write PLY", "16x", 1, |workload| {
            let (vertices, triangles) = (workload.finest_vertices(), workload.meshes[2].triangles());
            Box::new(move || _ = black_box(write_mesh(&mut Vec::new(), &vertices, None, triangles)))
        }),
        Stage::new("read PLY", "16x", 1, |workload| {
            let bytes = workload.finest_ply().expect("a mesh that fits into memory");
            let file = TemporaryFile::new(&bytes).expect("room for it on the disk");
            Box::new(move || _ = black_box(mesh::load(&file.0)))
        }),
    ]
}

/// A file that is removed on drop.
struct TemporaryFile(PathBuf);

impl TemporaryFile {
    fn new(bytes: &[u8]) -> std::io::Result<Self> {
        let path = std::env::temp_dir().join(format!("nextview-stage-{}.ply", std::process::id()));
        std::fs::write(&path, bytes)?;
        Ok(Self(path))
    }
}

impl Drop for TemporaryFile {
    fn drop(&mut self) {
        _ = std::fs::remove_file(&self.0);
    }
}

fn maps() -> Vec<Stage> {
    let octree = |workload: &Workload| -> Octree {
        Octree::from_map(&workload.map(Set::A, 0.005, N_IMAGES)).expect("a map of few voxels").pruned()
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
