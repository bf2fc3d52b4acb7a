use glam::IVec3;
use nextview::map::{Occupancy, Snapshot};
use nextview::{Cancel, Cancelled};

/// The input points of PC-NBV: 128 points of the seen surface.
///
/// They are the centres of occupied voxels, relative to the centre of the snapshot's box, in units of its
/// longest side; z is up. If there are more voxels, farthest-point sampling selects them: the first has the
/// lowest index, and each next one is the farthest from all before it, with the lowest index on ties. If
/// there are fewer, they are repeated in this order; if there are none, the centre of the box is.
#[derive(Clone, Debug, PartialEq)]
pub struct Cloud(Vec<[f32; 3]>);

impl Cloud {
    /// Number of points.
    pub const N_POINTS: usize = 128;

    /// Creates the cloud of a map.
    pub fn new(snapshot: &Snapshot, cancel: &Cancel) -> Result<Self, Cancelled> {
        let block = snapshot.block();
        let keys = (0..block.n_voxels()).filter(|&v| snapshot.occupancy()[v] == Occupancy::Occupied);
        let keys: Vec<IVec3> = keys.map(|voxel| block.key(voxel) - block.min()).collect();
        let middle = 0.5 * block.dims().as_dvec3();
        let point = |key: IVec3| ((key.as_dvec3() + 0.5 - middle) / (2.0 * middle.max_element())).as_vec3();
        let chosen = farthest(&keys, Self::N_POINTS, cancel)?;
        let points: Vec<[f32; 3]> = chosen.into_iter().map(|key| point(key).to_array()).collect();
        let points = if points.is_empty() { vec![[0.0; 3]] } else { points };
        Ok(Self(points.into_iter().cycle().take(Self::N_POINTS).collect()))
    }

    /// Creates a cloud of these points; `None` unless their number is right and all are finite.
    pub fn from_points(points: Vec<[f32; 3]>) -> Option<Self> {
        let is_whole =
            points.len() == Self::N_POINTS && points.iter().flatten().all(|number| number.is_finite());
        is_whole.then_some(Self(points))
    }

    /// Returns the points.
    pub fn points(&self) -> &[[f32; 3]] {
        &self.0
    }
}

/// Up to `n` of the voxels by farthest-point sampling.
fn farthest(keys: &[IVec3], n: usize, cancel: &Cancel) -> Result<Vec<IVec3>, Cancelled> {
    let mut dist_sq = vec![i64::MAX; keys.len()];
    let mut chosen = Vec::new();
    let mut next = keys.first().copied();
    while let Some(key) = next.filter(|_| chosen.len() < n) {
        cancel.check()?;
        chosen.push(key);
        let mut best = None;
        for (index, (other, dist_sq)) in keys.iter().zip(&mut dist_sq).enumerate() {
            *dist_sq = (*dist_sq).min((other - key).as_i64vec3().length_squared());
            if best.is_none_or(|(farthest, _)| *dist_sq > farthest) {
                best = Some((*dist_sq, index));
            }
        }
        next = best.filter(|&(dist_sq, _)| dist_sq > 0).map(|(_, index)| keys[index]);
    }
    Ok(chosen)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::UVec3;
    use nextview::geometry::random::Random;
    use nextview::geometry::{Lattice, VoxelBlock};
    use nextview::map::LogOdds;

    fn snapshot(is_occupied: impl Fn(IVec3) -> bool) -> Snapshot {
        let block = VoxelBlock::new(IVec3::new(-3, 5, 40), UVec3::new(20, 10, 14)).unwrap();
        let state = |key: IVec3| Some(LogOdds(if is_occupied(key - block.min()) { 2.0 } else { -1.0 }));
        Snapshot::from_fn(Lattice::new(0.01).unwrap(), block, state)
    }

    fn cloud(snapshot: &Snapshot) -> Cloud {
        Cloud::new(snapshot, &Cancel::default()).unwrap()
    }

    /// The literal definition.
    fn twin(keys: &[IVec3], n: usize) -> Vec<IVec3> {
        let mut chosen = vec![keys[0]];
        while chosen.len() < n {
            let gap = |key: &IVec3| chosen.iter().map(|c| (*c - *key).length_squared()).min().unwrap();
            let widest = keys.iter().map(gap).max().unwrap();
            chosen.push(*keys.iter().find(|key| gap(key) == widest).unwrap());
        }
        chosen
    }

    #[test]
    fn takes_the_farthest_voxels_from_the_lowest_index_on() {
        for seed in 0..5 {
            let mut random = Random::new(seed, 0);
            let drawn: Vec<IVec3> = (0..900).map(|_| (10.0 * random.in_cube()).as_ivec3()).collect();
            let mut keys: Vec<IVec3> = Vec::new();
            drawn.into_iter().for_each(|key| {
                if !keys.contains(&key) {
                    keys.push(key)
                }
            });
            assert_eq!(farthest(&keys, 100, &Cancel::default()).unwrap(), twin(&keys, 100));
        }
    }

    #[test]
    fn points_lie_in_a_cube_of_side_one() {
        let corner = cloud(&snapshot(|key| key == IVec3::ZERO));
        assert_eq!(corner.points(), [[-9.5 / 20.0, -4.5 / 20.0, -6.5 / 20.0]; Cloud::N_POINTS]);
        let all = cloud(&snapshot(|_| true));
        assert!(all.points().iter().flatten().all(|at| at.abs() < 0.5));
        assert!((1..Cloud::N_POINTS).all(|n| !all.points()[..n].contains(&all.points()[n])));
    }

    #[test]
    fn repeats_the_points_where_there_are_few() {
        let three = cloud(&snapshot(|key| key.y == 2 && key.z == 3 && key.x < 3));
        let points = three.points();
        assert!(points[..3] == [points[3], points[4], points[5]] && points[126] == points[0]);
        assert_eq!(cloud(&snapshot(|_| false)).points(), [[0.0; 3]; Cloud::N_POINTS]);
        assert_eq!(Cloud::from_points(points.to_vec()), Some(three.clone()));
        assert_eq!(Cloud::from_points(points[1..].to_vec()), None);
        assert_eq!(Cloud::from_points(vec![[0.0, f32::NAN, 0.0]; Cloud::N_POINTS]), None);
    }
}
