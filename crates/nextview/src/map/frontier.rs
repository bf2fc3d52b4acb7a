use super::{Occupancy, Snapshot};

/// Returns the frontier of a snapshot: the unknown voxels that share a face, edge or corner with at least one
/// free and at least one occupied voxel (the paper, section III.A), as indices in increasing order.
pub fn frontier(snapshot: &Snapshot) -> Vec<usize> {
    let [n_x, n_y, n_z] = snapshot.block().dims().to_array().map(|n| n as usize);
    let occupied = BitRows::new(snapshot, Occupancy::Occupied);
    let free = BitRows::new(snapshot, Occupancy::Free);
    let mut frontier = Vec::new();
    for row in 0..n_y * n_z {
        let around = RowsAround::new(row, n_y, n_z);
        for word in 0..occupied.n_words {
            // Few rows are near a surface, so most end here.
            let near_occupied = occupied.touched(&around, word);
            if near_occupied != 0 {
                let measured = occupied.words(row)[word] | free.words(row)[word];
                let bits = near_occupied & free.touched(&around, word) & !measured;
                let first = row * n_x + word * 64;
                frontier.extend(ones(bits).filter(|bit| word * 64 + bit < n_x).map(|bit| first + bit));
            }
        }
    }
    frontier
}

/// The voxels of one state, one bit each; every row along x begins a new word.
struct BitRows {
    bits: Vec<u64>,
    /// Words per row.
    n_words: usize,
}

/// A row and the rows that share a face or edge with it: y - 1 to y + 1 for each of z - 1 to z + 1.
struct RowsAround {
    n: usize,
    rows: [usize; 9],
}

impl BitRows {
    fn new(snapshot: &Snapshot, state: Occupancy) -> Self {
        let n_x = snapshot.block().dims().x as usize;
        let word = |voxels: &[Occupancy]| {
            voxels.iter().enumerate().fold(0, |word, (bit, &o)| word | u64::from(o == state) << bit)
        };
        let rows = snapshot.occupancy().chunks(n_x);
        Self { bits: rows.flat_map(|row| row.chunks(64)).map(word).collect(), n_words: n_x.div_ceil(64) }
    }

    fn words(&self, row: usize) -> &[u64] {
        &self.bits[row * self.n_words..][..self.n_words]
    }

    /// Returns a mask of the voxels in a word of the middle row that touch, or are, voxels of the state.
    fn touched(&self, around: &RowsAround, word: usize) -> u64 {
        let any =
            |word: usize| around.rows[..around.n].iter().fold(0, |any, &row| any | self.words(row)[word]);
        let here = any(word);
        let before = if word > 0 { any(word - 1) } else { 0 };
        let after = if word + 1 < self.n_words { any(word + 1) } else { 0 };
        here | here << 1 | here >> 1 | before >> 63 | after << 63
    }
}

impl RowsAround {
    fn new(row: usize, n_y: usize, n_z: usize) -> Self {
        let (y, z) = (row % n_y, row / n_y);
        let mut around = Self { n: 0, rows: [0; 9] };
        for z in z.saturating_sub(1)..n_z.min(z + 2) {
            for y in y.saturating_sub(1)..n_y.min(y + 2) {
                around.rows[around.n] = y + z * n_y;
                around.n += 1;
            }
        }
        around
    }
}

/// Returns the positions of the bits that are set, in increasing order.
fn ones(mut bits: u64) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        let bit = bits.trailing_zeros() as usize;
        let left = bits != 0;
        bits &= bits.wrapping_sub(1);
        left.then_some(bit)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{Lattice, VoxelBlock, random::Random};
    use crate::map::LogOdds;
    use glam::{IVec3, UVec3};
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn equals_the_definition(dims in prop::sample::select(vec![[3, 4, 5], [130, 2, 2], [64, 1, 3], [1, 1, 1]]), seed in any::<u64>()) {
            let block = VoxelBlock::new(IVec3::new(-1, 2, 0), UVec3::from_array(dims)).unwrap();
            let n = block.n_voxels();
            let mut random = Random::new(seed, 0);
            let states: Vec<usize> = (0..n).map(|_| random.index(3)).collect();
            let snapshot = Snapshot::from_fn(Lattice::new(0.01).unwrap(), block, |key| {
                match states[block.index(key).unwrap()] {
                    0 => None,
                    1 => Some(LogOdds(-0.4)),
                    _ => Some(LogOdds(0.8)),
                }
            });
            let touches = |i: usize, state| {
                (0..n).any(|j| {
                    j != i && (block.key(i) - block.key(j)).abs().max_element() == 1 && states[j] == state
                })
            };
            let expected: Vec<usize> =
                (0..n).filter(|&i| states[i] == 0 && touches(i, 1) && touches(i, 2)).collect();
            prop_assert_eq!(frontier(&snapshot), expected);
        }
    }
}
