use crate::tree::Octree;
use nextview::Error;
use nextview::geometry::Lattice;
use nextview::map::{LogOdds, OccupancyMap, SensorModel};

impl Octree {
    /// Returns the octree of a map, at its finest level.
    pub fn from_map(map: &OccupancyMap) -> Result<Self, Error> {
        let voxels = map.measured().map(|(key, value)| (key, value.0));
        Self::from_voxels(map.lattice().voxel_size(), voxels)
    }

    /// Returns the map of the octree; merged leaves become single voxels, colours are dropped. A leaf with
    /// log-odds of exactly 0 stays unknown (some tools create such leaves for space never measured). Fails if
    /// there are more than `max_voxels` voxels.
    pub fn to_map(&self, model: SensorModel, max_voxels: usize) -> Result<OccupancyMap, Error> {
        let expanded = self.expanded(max_voxels)?;
        let measured = expanded.leaves().filter(|leaf| leaf.log_odds != 0.0);
        let voxels = measured.map(|leaf| (leaf.min, LogOdds(leaf.log_odds)));
        OccupancyMap::from_voxels(Lattice::new(self.voxel_size())?, model, voxels)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::IVec3;
    use proptest::prelude::*;

    fn key() -> impl Strategy<Value = IVec3> {
        (-20..20, -20..20, -20..20).prop_map(|(x, y, z)| IVec3::new(x, y, z))
    }

    proptest! {
        #[test]
        fn octomap_form_keeps_every_bit(
            voxels in prop::collection::vec((key(), (-2.0..3.5).prop_map(|x| LogOdds(x as f32))), 1..60),
        ) {
            let model = SensorModel::default();
            let map = OccupancyMap::from_voxels(Lattice::new(0.01).unwrap(), model, voxels).unwrap();
            let octree = Octree::from_map(&map).unwrap();
            for form in [octree.clone(), octree.pruned()] {
                let back = form.to_map(model, 1_000_000).unwrap();
                let nonzero: Vec<_> = map.voxels().into_iter().filter(|(_, v)| v.0 != 0.0).collect();
                prop_assert_eq!(back.voxels(), nonzero);
            }
        }
    }
}
