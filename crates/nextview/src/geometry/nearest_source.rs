use super::VoxelBlock;

/// A distance transform: the nearest of some source voxels for every voxel of a block.
///
/// Exact, in time proportional to the number of voxels: Felzenszwalb & Huttenlocher 2012 in integers.
#[derive(Clone, Debug)]
pub(crate) struct NearestSource {
    nearest: Vec<Nearest>,
}

/// The nearest source of a voxel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Nearest {
    /// Squared distance between the centres, in voxels; [`NONE`](Self::NONE) without any source.
    pub squared: u32,
    /// Its index in the block; ties are resolved deterministically.
    pub source: u32,
}

impl Nearest {
    pub const NONE: u32 = u32::MAX;
}

impl NearestSource {
    /// Computes the transform; the sources are given by index.
    pub fn new(block: &VoxelBlock, is_source: impl Fn(usize) -> bool) -> Self {
        let at = |index: usize| Nearest {
            squared: if is_source(index) { 0 } else { Nearest::NONE },
            source: index as u32,
        };
        let mut nearest: Vec<Nearest> = (0..block.n_voxels()).map(at).collect();
        let mut line = LineBuffers::default();
        for (stride, length) in block.strides().into_iter().zip(block.dims().to_array()) {
            let starts = (0..nearest.len()).filter(|start| start / stride % length as usize == 0);
            starts.for_each(|start| line.relax(&mut nearest[start..], stride, length as usize));
        }
        Self { nearest }
    }

    /// Returns the nearest source of a voxel.
    pub fn of(&self, voxel: usize) -> Nearest {
        self.nearest[voxel]
    }
}

/// Buffers for one line of voxels along an axis.
#[derive(Default)]
struct LineBuffers {
    /// A copy of the line.
    before: Vec<Nearest>,
    /// The positions whose parabolas form the lower envelope, each with the position from which it is the
    /// lowest.
    envelope: Vec<(usize, i64)>,
}

impl LineBuffers {
    /// Updates each voxel from the sources of the others in its line.
    fn relax(&mut self, nearest: &mut [Nearest], stride: usize, length: usize) {
        self.before.clear();
        self.before.extend((0..length).map(|place| nearest[place * stride]));
        self.find_envelope();
        let mut parts = self.envelope.iter().peekable();
        let Some(&(mut lowest, _)) = parts.next() else { return };
        for place in 0..length {
            while let Some(&&(next, from)) = parts.peek().filter(|(_, from)| *from <= place as i64) {
                debug_assert!(from >= 0, "places count from 0");
                lowest = next;
                parts.next();
            }
            let Nearest { squared, source } = self.before[lowest];
            let distance = place.abs_diff(lowest) as u32;
            nearest[place * stride] = Nearest { squared: squared + distance * distance, source };
        }
    }

    fn find_envelope(&mut self) {
        self.envelope.clear();
        let heights = self.before.iter().map(|nearest| nearest.squared).enumerate();
        for (place, height) in heights.filter(|(_, height)| *height != Nearest::NONE) {
            let mut from = 0;
            while let Some(&(other, since)) = self.envelope.last() {
                from = first_below(place as i64, height, other as i64, self.before[other].squared);
                if from > since {
                    break;
                }
                self.envelope.pop();
                from = 0;
            }
            if from < self.before.len() as i64 {
                self.envelope.push((place, from));
            }
        }
    }
}

/// Returns the first position where the parabola at `place` is lower than that at `other`, which lies before
/// it.
fn first_below(place: i64, height: u32, other: i64, other_height: u32) -> i64 {
    let difference = place * place - other * other + height as i64 - other_height as i64;
    difference.div_euclid(2 * (place - other)) + 1
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{IVec3, UVec3};
    use proptest::prelude::*;

    proptest! {
        /// The slow twin: all pairs.
        #[test]
        fn finds_the_nearest(dims in prop::array::uniform3(1_u32..9), every in 1_usize..60, seed in 0_usize..1000) {
            let block = VoxelBlock::new(IVec3::splat(-3), UVec3::from_array(dims)).unwrap();
            let is_source = |index: usize| ((index * 7919 + seed) % 61).is_multiple_of(every);
            let sources: Vec<usize> = (0..block.n_voxels()).filter(|&i| is_source(i)).collect();
            let found = NearestSource::new(&block, is_source);
            for voxel in 0..block.n_voxels() {
                let squared = |&source: &usize| (block.key(voxel) - block.key(source)).length_squared() as u32;
                let Nearest { squared: distance, source } = found.of(voxel);
                prop_assert_eq!(distance, sources.iter().map(squared).min().unwrap_or(Nearest::NONE));
                if !sources.is_empty() {
                    prop_assert!(is_source(source as usize));
                    prop_assert_eq!(squared(&(source as usize)), distance);
                }
            }
        }
    }
}
