use crate::weights::Layer;

/// A convolution of channels of N x N x N cells, rectified, and the maximum of each 2 x 2 x 2 cells.
#[inline(always)]
pub(crate) fn convolve<const N: usize>(channels: &[f32], layer: &Layer) -> Vec<f32> {
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

/// The channels with zero padding.
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

/// A row of the convolution, all its cells in parallel: for each, the bias and then, in order, the
/// contribution of each cell around it in each channel.
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

/// Adds the maximum of each 2 x 2 x 2 values, at least 0.
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

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    /// The slow reference of a convolution with its rectifier, by definition.
    pub fn slow_convolution(input: &[f32], side: usize, layer: &Layer) -> Vec<f32> {
        let n_in = input.len() / side.pow(3);
        let mut output = Vec::new();
        for o in 0..layer.bias.len() {
            for i in 0..side {
                for j in 0..side {
                    for k in 0..side {
                        let mut sum = layer.bias[o];
                        for c in 0..n_in {
                            for around in 0..27 {
                                // One too high, to be positive; outside the grid are zeros.
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

    /// The slow reference of pooling.
    pub fn slow_pool(input: &[f32], side: usize) -> Vec<f32> {
        let mut output = vec![f32::NEG_INFINITY; input.len() / 8];
        for (index, &value) in input.iter().enumerate() {
            let (c, i, j, k) =
                (index / side.pow(3), index / (side * side) % side, index / side % side, index % side);
            let place = &mut output[((c * side / 2 + i / 2) * side / 2 + j / 2) * side / 2 + k / 2];
            *place = place.max(value);
        }
        output
    }
}
