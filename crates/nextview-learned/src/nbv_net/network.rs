use super::error::WeightsError;
use super::grid::Grid;
use super::layout::CHANNELS;
use super::views::N_VIEWS;
use super::weights::{self, Layer};
use pulp::{Arch, Simd, WithSimd};

/// The network of the paper: from a [`Grid`] to a number for each of the 14 views, the larger, the better.
///
/// Three 3D convolutions (10, 12 and 8 filters of 3 x 3 x 3 cells, a border of zeros), each followed by the
/// larger of 0 and the value, and by the largest of eight neighbours; then five fully connected layers of
/// 1500, 500, 100, 50 and 14 units, rectified except the last. The authors' code rectifies the last one, too,
/// which separates views no better and makes training harder.
///
/// Every number is computed in the same order of operations on every CPU, by one thread, so that the results
/// have the same bits.
///
/// ```
/// use nextview_learned::nbv_net::{Grid, Network};
///
/// let nothing_known = Grid::from_bytes(&[127; Grid::N_CELLS]).unwrap();
/// assert_eq!(Network::default().logits(&nothing_known).len(), 14);
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Network {
    convolutions: Vec<Layer>,
    /// With the weights of an input beside each other.
    dense: Vec<Layer>,
}

/// The library's weights; `docs/methods/nbv-net.md` describes the training.
const WEIGHTS: &[u8] = include_bytes!("../../weights/nbv_net.safetensors");

impl Default for Network {
    fn default() -> Self {
        Self::from_safetensors(WEIGHTS).expect("the library's own weights are whole")
    }
}

impl Network {
    /// The network whose weights are the content of a safetensors file: the tensors of the published network,
    /// by its names (`conv1.weight` to `fc5.bias`), in single or half precision.
    pub fn from_safetensors(file: &[u8]) -> Result<Self, WeightsError> {
        let mut convolutions = weights::read(file)?;
        let dense = convolutions.split_off(CHANNELS.len() - 1);
        Ok(Self { convolutions, dense: dense.into_iter().map(transposed).collect() })
    }

    /// A number for each view, whose exponential is proportional to the probability of the view.
    pub fn logits(&self, grid: &Grid) -> [f32; N_VIEWS] {
        Arch::new().dispatch(Forward { network: self, grid })
    }
}

/// The layer with the weights of each input, instead of each output, beside each other.
fn transposed(layer: Layer) -> Layer {
    let n_out = layer.bias.len();
    let n_in = layer.weight.len() / n_out;
    let weight = (0..n_in * n_out).map(|i| layer.weight[i % n_out * n_in + i / n_out]).collect();
    Layer { weight, ..layer }
}

/// Computes the logits, with the instructions of the CPU.
#[derive(Clone, Copy)]
struct Forward<'a> {
    network: &'a Network,
    grid: &'a Grid,
}

impl WithSimd for Forward<'_> {
    type Output = [f32; N_VIEWS];

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> Self::Output {
        let Self { network, grid } = self;
        let [first, second, third] = &network.convolutions[..] else { unreachable!("there are three") };
        let values = convolve::<32>(grid.cells(), first);
        let values = convolve::<16>(&values, second);
        let mut values = convolve::<8>(&values, third);
        for (n, layer) in network.dense.iter().enumerate() {
            if n > 0 {
                values.iter_mut().for_each(|value| *value = rectified(*value));
            }
            values = connect(&values, layer);
        }
        std::array::from_fn(|view| values[view])
    }
}

/// A convolution of channels of N x N x N cells, rectified, and the largest of each 2 x 2 x 2 cells.
#[inline(always)]
fn convolve<const N: usize>(channels: &[f32], layer: &Layer) -> Vec<f32> {
    let padded = padded::<N>(channels);
    let n_in = channels.len() / N.pow(3);
    let mut values = vec![0.0; N.pow(3)];
    let mut pooled = Vec::with_capacity(layer.bias.len() * (N / 2).pow(3));
    for (weights, &bias) in layer.weight.chunks_exact(27 * n_in).zip(&layer.bias) {
        for (row, values) in values.chunks_exact_mut(N).enumerate() {
            values.copy_from_slice(&row_of_channel::<N>(&padded, row, weights, bias));
        }
        pool::<N>(&values, &mut pooled);
    }
    pooled
}

/// The channels with a border of zeros around each.
#[inline(always)]
fn padded<const N: usize>(channels: &[f32]) -> Vec<f32> {
    let side = N + 2;
    let mut padded = vec![0.0; channels.len() / N.pow(3) * side.pow(3)];
    for (row, values) in channels.chunks_exact(N).enumerate() {
        let (channel, i, j) = (row / (N * N), row / N % N, row % N);
        let begin = ((channel * side + i + 1) * side + j + 1) * side + 1;
        padded[begin..begin + N].copy_from_slice(values);
    }
    padded
}

/// A row of the convolution, all its cells beside each other: for each, the bias and then, one after the
/// other, the contribution of each cell around it in each channel.
#[inline(always)]
#[allow(clippy::needless_range_loop, reason = "iterators are not always inlined into vector instructions")]
fn row_of_channel<const N: usize>(padded: &[f32], row: usize, weights: &[f32], bias: f32) -> [f32; N] {
    let (i, j, side) = (row / N, row % N, N + 2);
    let mut sums = [bias; N];
    for (around, weights) in weights.chunks_exact(3).enumerate() {
        let (channel, di, dj) = (around / 9, around / 3 % 3, around % 3);
        let begin = ((channel * side + i + di) * side + j + dj) * side;
        let cells = &padded[begin..begin + side];
        for dk in 0..3 {
            for k in 0..N {
                sums[k] += weights[dk] * cells[k + dk];
            }
        }
    }
    sums
}

/// Adds the largest of each 2 x 2 x 2 values, or 0 if that is larger.
#[inline(always)]
fn pool<const N: usize>(values: &[f32], pooled: &mut Vec<f32>) {
    let half = N / 2;
    for cell in 0..half.pow(3) {
        let (i, j, k) = (cell / (half * half), cell / half % half, cell % half);
        let mut largest = 0.0;
        for corner in 0..8 {
            let value = values[((2 * i + corner / 4) * N + 2 * j + corner / 2 % 2) * N + 2 * k + corner % 2];
            largest = if value > largest { value } else { largest };
        }
        pooled.push(largest);
    }
}

/// A fully connected layer: for each output the bias and then, one after the other, the contribution of each
/// input.
#[inline(always)]
#[allow(clippy::needless_range_loop, reason = "iterators are not always inlined into vector instructions")]
fn connect(inputs: &[f32], layer: &Layer) -> Vec<f32> {
    let mut outputs = layer.bias.clone();
    let n = outputs.len();
    for (input, weights) in inputs.iter().zip(layer.weight.chunks_exact(n)) {
        for output in 0..n {
            outputs[output] += input * weights[output];
        }
    }
    outputs
}

#[inline(always)]
fn rectified(value: f32) -> f32 {
    if value > 0.0 { value } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nextview::geometry::random::Random;

    fn network(seed: u64) -> (Network, Vec<Layer>) {
        let file = weights::tests::file(&weights::tests::tensors(seed));
        (Network::from_safetensors(&file).unwrap(), weights::read(&file).unwrap())
    }

    /// A grid of unknown, free and occupied balls.
    fn grid(seed: u64) -> Grid {
        let mut random = Random::new(seed, 3);
        let mut bytes = vec![127; Grid::N_CELLS];
        for _ in 0..12 {
            let (byte, radius) = ([30, 60, 127, 178, 246][random.index(5)], random.range(2.0, 12.0));
            let center = [(); 3].map(|()| random.range(0.0, 32.0));
            for (cell, old) in bytes.iter_mut().enumerate() {
                let at = [cell / 1024, cell / 32 % 32, cell % 32].map(|at| at as f64 + 0.5);
                let dist_sq: f64 = at.iter().zip(center).map(|(a, c)| (a - c) * (a - c)).sum();
                *old = if dist_sq < radius * radius { byte } else { *old };
            }
        }
        Grid::from_bytes(&bytes).unwrap()
    }

    /// The slow twin of a convolution with its rectifier, as the definition says.
    fn slow_convolution(input: &[f32], side: usize, layer: &Layer) -> Vec<f32> {
        let n_in = input.len() / side.pow(3);
        let mut output = Vec::new();
        for o in 0..layer.bias.len() {
            for i in 0..side {
                for j in 0..side {
                    for k in 0..side {
                        let mut sum = layer.bias[o];
                        for c in 0..n_in {
                            for around in 0..27 {
                                // One too high, so that they are positive; beside the grid are zeros.
                                let at = [i + around / 9, j + around / 3 % 3, k + around % 3];
                                let is_in = at.iter().all(|at| (1..=side).contains(at));
                                let index = ((c * side + at[0].max(1) - 1) * side + at[1].max(1) - 1) * side;
                                let value = if is_in { input[index + at[2] - 1] } else { 0.0 };
                                sum += layer.weight[(o * n_in + c) * 27 + around] * value;
                            }
                        }
                        output.push(sum.max(0.0));
                    }
                }
            }
        }
        output
    }

    fn slow_pool(input: &[f32], side: usize) -> Vec<f32> {
        let mut output = vec![f32::NEG_INFINITY; input.len() / 8];
        for (index, &value) in input.iter().enumerate() {
            let (c, i, j, k) =
                (index / side.pow(3), index / (side * side) % side, index / side % side, index % side);
            let place = &mut output[((c * side / 2 + i / 2) * side / 2 + j / 2) * side / 2 + k / 2];
            *place = place.max(value);
        }
        output
    }

    fn slow_logits(layers: &[Layer], grid: &Grid) -> Vec<f32> {
        let mut values = grid.cells().to_vec();
        for (layer, side) in layers.iter().zip([32, 16, 8]) {
            values = slow_pool(&slow_convolution(&values, side, layer), side);
        }
        for (n, layer) in layers[3..].iter().enumerate() {
            let output = |(o, &bias): (usize, &f32)| {
                let weights = &layer.weight[o * values.len()..];
                let sum = values.iter().zip(weights).fold(bias, |sum, (value, weight)| sum + value * weight);
                if n < 4 { sum.max(0.0) } else { sum }
            };
            values = layer.bias.iter().enumerate().map(output).collect();
        }
        values
    }

    #[test]
    fn computes_what_the_slow_twin_computes_to_the_bit() {
        for seed in 0..4 {
            let (network, layers) = network(seed);
            let grid = grid(seed);
            let logits = network.logits(&grid);
            assert_eq!(logits.as_slice(), slow_logits(&layers, &grid), "seed {seed}");
            assert!(logits.iter().any(|logit| logit.abs() > 1e-3), "{logits:?}");
        }
    }

    #[test]
    fn has_the_same_bits_with_all_instructions() {
        let (network, grid) = (Network::default(), grid(9));
        let found = network.logits(&grid).map(f32::to_bits);
        assert_eq!(
            Forward { network: &network, grid: &grid }.with_simd(pulp::Scalar::new()).map(f32::to_bits),
            found
        );
    }

    #[test]
    fn huge_weights_do_no_harm() {
        let (mut network, _) = network(1);
        network.dense.iter_mut().flat_map(|layer| &mut layer.weight).for_each(|weight| *weight *= 1e30);
        network.logits(&grid(1));
    }
}
