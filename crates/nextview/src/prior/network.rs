use super::VoxelFeatures;
use pulp::{Arch, Simd, WithSimd};
use rayon::prelude::*;

/// A small network from the features of a voxel to logits: two hidden layers of rectified linear units.
///
/// Every voxel is computed in the same order of operations on every CPU, so that the results have the same bits.
#[derive(Clone, Debug, PartialEq)]
pub struct Network {
    n_outputs: usize,
    /// Subtracted from each feature, and what it is multiplied with then.
    mean: [f32; VoxelFeatures::N],
    scale: [f32; VoxelFeatures::N],
    /// Of the three layers one after the other: for each input the weights to all outputs, then the biases.
    weights: Vec<f32>,
}

/// The units of the hidden layers.
const HIDDEN: [usize; 2] = [32, 16];

/// Number of weights of the layers before the last.
const FIRST: usize = (VoxelFeatures::N + 1) * HIDDEN[0];
const SECOND: usize = (HIDDEN[0] + 1) * HIDDEN[1];

/// Voxels that a thread computes at a time.
const CHUNK: usize = 512;

impl Network {
    /// The units of the hidden layers.
    pub const HIDDEN: [usize; 2] = HIDDEN;

    /// How many numbers describe a network with so many outputs.
    pub const fn n_numbers(n_outputs: usize) -> usize {
        2 * VoxelFeatures::N + FIRST + SECOND + (HIDDEN[1] + 1) * n_outputs
    }

    /// The network that these numbers describe: mean and scale of the features, then the weights of each layer, for each input those to all
    /// outputs, and last the biases. None unless there are [`n_numbers`](Self::n_numbers), all finite.
    pub fn from_numbers(numbers: &[f32], n_outputs: usize) -> Option<Self> {
        if numbers.len() != Self::n_numbers(n_outputs) || numbers.iter().any(|number| !number.is_finite()) {
            return None;
        }
        let (mean, rest) = numbers.split_first_chunk()?;
        let (scale, weights) = rest.split_first_chunk()?;
        Some(Self { n_outputs, mean: *mean, scale: *scale, weights: weights.to_vec() })
    }

    /// The numbers it is made from.
    pub fn numbers(&self) -> Vec<f32> {
        self.mean.iter().chain(&self.scale).chain(&self.weights).copied().collect()
    }

    /// The probabilities that the logits of each row stand for, row after row.
    pub fn probabilities(&self, rows: &[[f32; VoxelFeatures::N]]) -> Vec<f32> {
        let mut out = vec![0.0; rows.len() * self.n_outputs];
        let parts = out.par_chunks_mut(CHUNK * self.n_outputs).zip(rows.par_chunks(CHUNK));
        parts.for_each(|(out, rows)| Arch::new().dispatch(Forward { network: self, rows, out }));
        out
    }
}

/// Computes probabilities, with the instructions of the CPU.
struct Forward<'a> {
    network: &'a Network,
    rows: &'a [[f32; VoxelFeatures::N]],
    out: &'a mut [f32],
}

impl WithSimd for Forward<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { network, rows, out } = self;
        let n = network.n_outputs;
        for row in 0..rows.len() {
            let hidden = network.hidden(&rows[row]);
            let last = &network.weights[FIRST + SECOND..];
            let out = &mut out[row * n..(row + 1) * n];
            out.copy_from_slice(&last[HIDDEN[1] * n..]);
            for input in 0..HIDDEN[1] {
                for output in 0..n {
                    out[output] += hidden[input] * last[input * n + output];
                }
            }
            for logit in out {
                *logit = 1.0 / (1.0 + (-*logit).exp());
            }
        }
    }
}

impl Network {
    #[inline(always)]
    #[allow(
        clippy::needless_range_loop,
        reason = "iterators are not always inlined into vector instructions"
    )]
    fn hidden(&self, row: &[f32; VoxelFeatures::N]) -> [f32; HIDDEN[1]] {
        let (first, second) = self.weights[..FIRST + SECOND].split_at(FIRST);
        let mut wide = [0.0; HIDDEN[0]];
        wide.copy_from_slice(&first[VoxelFeatures::N * HIDDEN[0]..]);
        for input in 0..VoxelFeatures::N {
            let value = (row[input] - self.mean[input]) * self.scale[input];
            let weights = &first[input * HIDDEN[0]..][..HIDDEN[0]];
            for unit in 0..HIDDEN[0] {
                wide[unit] += value * weights[unit];
            }
        }
        let mut narrow = [0.0; HIDDEN[1]];
        narrow.copy_from_slice(&second[HIDDEN[0] * HIDDEN[1]..]);
        for input in 0..HIDDEN[0] {
            let value = if wide[input] > 0.0 { wide[input] } else { 0.0 };
            let weights = &second[input * HIDDEN[1]..][..HIDDEN[1]];
            for unit in 0..HIDDEN[1] {
                narrow[unit] += value * weights[unit];
            }
        }
        for unit in 0..HIDDEN[1] {
            narrow[unit] = if narrow[unit] > 0.0 { narrow[unit] } else { 0.0 };
        }
        narrow
    }
}
