//! Voxel solids whose boundary is a 2-manifold.

use nextview::geometry::VoxelBlock;
use nextview::{Cancel, Cancelled};

/// Makes more voxels of a block inside (negative) until the boundary between inside and outside is a
/// 2-manifold, and returns for each voxel whether it was added.
///
/// The boundary is a 2-manifold if no two voxels of the same side touch only across an edge or a corner
/// (well-composed, Latecki et al. 1995). Among the voxels that separate such a pair, the one with the value
/// nearest to inside is added, the lowest index on ties (a deterministic form of Siqueira et al. 2008); it is
/// set to `inside`, which must be negative. Only voxels within the bounding box of those inside are added.
pub(super) fn make_well_composed(
    block: &VoxelBlock,
    values: &mut [f32],
    inside: f32,
    cancel: &Cancel,
) -> Result<Vec<bool>, Cancelled> {
    let mut added = vec![false; values.len()];
    loop {
        let mut is_done = true;
        for first in first_corners(block) {
            let cell = corners(block, first);
            let Some(corner) = critical(cell.map(|i| values[i])) else { continue };
            values[cell[corner]] = inside;
            added[cell[corner]] = true;
            is_done = false;
        }
        cancel.check()?;
        if is_done {
            return Ok(added);
        }
    }
}

/// Returns the first corners of all cells; a cell is the cube between eight voxel centres.
pub(super) fn first_corners(block: &VoxelBlock) -> impl Iterator<Item = usize> {
    let [n_x, n_y, n_z] = block.dims().to_array().map(|n| n as usize - 1);
    let [x, y, z] = block.strides();
    (0..n_z).flat_map(move |k| (0..n_y).flat_map(move |j| (0..n_x).map(move |i| i * x + j * y + k * z)))
}

/// Returns the voxels at the corners of a cell, x varying fastest.
pub(super) fn corners(block: &VoxelBlock, first: usize) -> [usize; 8] {
    let [x, y, z] = block.strides();
    std::array::from_fn(|i| first + (i & 1) * x + (i >> 1 & 1) * y + (i >> 2) * z)
}

/// Returns the corner to add if two corners, both inside or both outside, are connected only diagonally:
/// across a face or through the cell. `None` if there are no such corners.
fn critical(values: [f32; 8]) -> Option<usize> {
    let inside = (0..8).fold(0_u8, |mask, i| mask | u8::from(values[i] < 0.0) << i);
    if matches!(inside, 0 | 0xff) {
        return None;
    }
    let nearest =
        |mask: u8| (0..8).filter(|i| mask >> i & 1 == 1).min_by(|&i, &j| values[i].total_cmp(&values[j]));
    let face = faces().find(|(diagonal, other)| inside & (diagonal | other) == *diagonal);
    if let Some((_, other)) = face {
        return nearest(other);
    }
    let across = (0..4).map(|i| 1_u8 << i | 1 << (7 - i));
    let is_critical = |pair: &u8| inside == *pair || !inside == *pair;
    across.into_iter().find(is_critical).and_then(|_| nearest(!inside))
}

/// Returns the diagonal pairs of corners of a cell's faces, and the corners that separate them.
fn faces() -> impl Iterator<Item = (u8, u8)> {
    let face =
        |[a, b, c, d]: [u8; 4]| [(1 << a | 1 << d, 1 << b | 1 << c), (1 << b | 1 << c, 1 << a | 1 << d)];
    let faces = [[0, 1, 2, 3], [4, 5, 6, 7], [0, 1, 4, 5], [2, 3, 6, 7], [0, 2, 4, 6], [1, 3, 5, 7]];
    faces.into_iter().flat_map(face)
}

/// Fills outside voxels not connected across faces to the first voxel, which must be outside. Returns for
/// each voxel whether it was filled. A well-composed solid stays well-composed.
pub(super) fn fill_cavities(block: &VoxelBlock, values: &mut [f32], inside: f32) -> Vec<bool> {
    let mut is_reached = vec![false; values.len()];
    is_reached[0] = true;
    let mut queue = vec![0];
    while let Some(index) = queue.pop() {
        for next in beside(block, index) {
            if values[next] >= 0.0 && !is_reached[next] {
                is_reached[next] = true;
                queue.push(next);
            }
        }
    }
    let filled: Vec<bool> = values.iter().zip(&is_reached).map(|(value, r)| *value >= 0.0 && !r).collect();
    values.iter_mut().zip(&filled).filter(|(_, filled)| **filled).for_each(|(value, _)| *value = inside);
    filled
}

/// Returns the up to six face neighbours of a voxel.
fn beside(block: &VoxelBlock, index: usize) -> impl Iterator<Item = usize> + use<> {
    let (strides, dims) = (block.strides(), block.dims().to_array());
    (0..3).flat_map(move |axis| {
        let (stride, along) = (strides[axis], index / strides[axis] % dims[axis] as usize);
        let below = (along > 0).then(|| index - stride);
        let above = (along + 1 < dims[axis] as usize).then(|| index + stride);
        [below, above].into_iter().flatten()
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface_nets;
    use crate::watertight::assert_watertight;
    use glam::{IVec3, UVec3};
    use nextview::geometry::Lattice;
    use nextview::geometry::random::Random;

    fn block(n: u32) -> VoxelBlock {
        VoxelBlock::new(IVec3::ZERO, UVec3::splat(n)).unwrap()
    }

    /// Random voxels inside, with a layer outside around them.
    fn random_values(block: &VoxelBlock, share: f64, seed: u64) -> Vec<f32> {
        let mut random = Random::new(seed, 0);
        let is_border = |key: IVec3| key.min_element() == 0 || (key - block.max()).max_element() == 0;
        (0..block.n_voxels())
            .map(|i| match random.unit() < share && !is_border(block.key(i)) {
                true => -1.0,
                false => random.unit() as f32 + 0.1,
            })
            .collect()
    }

    #[test]
    fn any_voxels_become_a_solid_with_a_closed_surface() {
        let (block, lattice) = (block(9), Lattice::new(0.01).unwrap());
        for (seed, share) in (0..40).zip([0.02, 0.1, 0.3, 0.5, 0.8].into_iter().cycle()) {
            let before = random_values(&block, share, seed);
            let mut values = before.clone();
            let added = make_well_composed(&block, &mut values, -0.1, &Cancel::default()).unwrap();
            let filled = fill_cavities(&block, &mut values, -0.1);
            for i in 0..values.len() {
                let is_changed = added[i] || filled[i];
                assert_eq!(values[i], if is_changed { -0.1 } else { before[i] }, "{seed}: voxel {i}");
            }
            let mesh = surface_nets(&lattice, &block, |i| Some(f64::from(values[i])));
            if before.iter().any(|value| *value < 0.0) {
                assert_watertight(&mesh);
            }
            assert!(!fill_cavities(&block, &mut values, -0.1).contains(&true));
            assert!(first_corners(&block).all(|i| critical(corners(&block, i).map(|i| values[i])).is_none()));
        }
    }

    /// The slow twin: a cell's pattern is critical unless its inside and its outside corners are each
    /// connected along edges, in the cell and in each of its faces.
    #[test]
    fn critical_cells_are_those_with_a_side_in_pieces_that_face_each_other() {
        let connected = |mask: u8| {
            let mut part = mask & mask.wrapping_neg();
            for _ in 0..8 {
                let near = (0..8_u8).filter(|i| part >> i & 1 == 1);
                part |= near.fold(0, |near, i| near | 1 << (i ^ 1) | 1 << (i ^ 2) | 1 << (i ^ 4)) & mask;
            }
            part == mask
        };
        let faces = [0b0000_1111_u8, 0b1111_0000, 0b0011_0011, 0b1100_1100, 0b0101_0101, 0b1010_1010];
        for inside in 0..=255_u8 {
            let on_face = |face: &u8| !connected(inside & face) && !connected(!inside & face);
            let pair = |mask: u8| {
                mask.count_ones() == 2 && (mask & 0x0f).count_ones() == 1 && {
                    let [a, b] = [mask.trailing_zeros(), 7 - mask.leading_zeros()];
                    a ^ b == 7
                }
            };
            let expected = faces.iter().any(on_face) || pair(inside) || pair(!inside);
            let values = std::array::from_fn(|i| if inside >> i & 1 == 1 { -1.0 } else { 1.0 });
            assert_eq!(critical(values).is_some(), expected, "{inside:08b}");
            assert!(critical(values).is_none_or(|corner| inside >> corner & 1 == 0));
        }
    }

    #[test]
    fn cavities_are_filled_and_bays_are_not() {
        let block = block(5);
        let shell = |key: IVec3| (key - 2).abs().max_element() == 1;
        let mut values: Vec<f32> = (0..125).map(|i| if shell(block.key(i)) { -1.0 } else { 1.0 }).collect();
        let mut open = values.clone();
        let middle = block.index(IVec3::splat(2)).unwrap();
        let filled = fill_cavities(&block, &mut values, -0.5);
        assert_eq!((filled.iter().filter(|is| **is).count(), values[middle]), (1, -0.5));
        open[block.index(IVec3::new(2, 2, 3)).unwrap()] = 1.0;
        assert!(!fill_cavities(&block, &mut open, -0.5).contains(&true));
    }
}
