//! Maps in the form of `octomap_msgs`: an OctoMap file without its header.

use crate::messages::{Bytes, Header, Octomap};
use nextview::map::OccupancyMap;
use nextview_octomap::Octree;

/// The line after which the tree begins.
const END_OF_HEAD: &[u8] = b"\ndata\n";

/// Two messages: the map with P(occupied) of each voxel, and the map with free and occupied voxels only.
pub fn messages(map: &OccupancyMap, frame: &str) -> Result<[Octomap; 2], nextview::Error> {
    let octree = Octree::from_map(map)?.pruned();
    let (mut full, mut binary) = (Vec::new(), Vec::new());
    octree.write_ot(&mut full)?;
    octree.write_bt(&mut binary)?;
    Ok([message(&octree, frame, false, &full), message(&octree, frame, true, &binary)])
}

fn message(octree: &Octree, frame: &str, binary: bool, file: &[u8]) -> Octomap {
    let head = file.windows(END_OF_HEAD.len()).position(|window| window == END_OF_HEAD);
    let tree = head.map_or(&[][..], |at| &file[at + END_OF_HEAD.len()..]);
    Octomap {
        header: Header::of(frame),
        binary,
        id: "OcTree".to_owned(),
        resolution: octree.voxel_size(),
        data: Bytes(tree.to_vec()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nextview::geometry::Lattice;
    use nextview::map::SensorModel;

    #[test]
    fn a_message_is_the_file_without_its_head() {
        let map = OccupancyMap::new(Lattice::new(0.02).unwrap(), SensorModel::default()).unwrap();
        let mut file = Vec::new();
        Octree::from_map(&map).unwrap().write_ot(&mut file).unwrap();
        let [full, binary] = messages(&map, "map").unwrap();
        assert!(!full.binary && binary.binary && full.resolution == 0.02 && full.header.frame_id == "map");
        let (head, tree) = file.split_at(file.len() - full.data.0.len());
        assert!(head.ends_with(END_OF_HEAD) && tree == full.data.0);
    }
}
