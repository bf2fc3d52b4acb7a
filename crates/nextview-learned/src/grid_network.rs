use crate::grid::Grid;
use crate::layers::{Dense, convolve, rectify};
use crate::weights::{self, Layer, NetworkLayout, WeightsError};
use pulp::{Arch, Simd, WithSimd};

/// Channels before, between and after the convolutions.
const CHANNELS: [usize; 4] = [1, 10, 12, 8];

/// Units before the first fully connected layer: eight channels of 4 x 4 x 4 cells.
pub(crate) const N_FEATURES: usize = 512;

/// A network that takes a [`Grid`]: NBV-Net and NBV regression, which differ in the fully connected layers.
///
/// Three 3D convolutions (10, 12 and 8 filters of 3 x 3 x 3 cells, zero padding), each followed by a
/// rectifier and max pooling over eight neighbours; then fully connected layers, rectified except the last.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct GridNetwork {
    convolutions: Vec<Layer>,
    dense: Vec<Dense>,
}

/// The layers of the network with this name, named as in the published program; `units` before, between and
/// after the fully connected ones.
pub(crate) fn layout(network: &'static str, units: &[usize]) -> NetworkLayout {
    let convolutions =
        CHANNELS.windows(2).zip(1..).map(|(n, i)| (format!("conv{i}"), vec![n[1], n[0], 3, 3, 3]));
    let dense = units.windows(2).zip(1..).map(|(n, i)| (format!("fc{i}"), vec![n[1], n[0]]));
    NetworkLayout { network, layers: convolutions.chain(dense).collect() }
}

impl GridNetwork {
    /// Reads the network's weights from a safetensors file.
    pub fn read(file: &[u8], layout: &NetworkLayout) -> Result<Self, WeightsError> {
        let mut convolutions = weights::read(file, layout)?;
        let dense = convolutions.split_off(CHANNELS.len() - 1);
        Ok(Self { convolutions, dense: dense.into_iter().map(Dense::new).collect() })
    }

    /// Returns the values of the last layer.
    pub fn outputs(&self, grid: &Grid) -> Vec<f32> {
        Arch::new().dispatch(GridForward { network: self, grid })
    }
}

/// Computes the outputs with the CPU's instructions.
#[derive(Clone, Copy)]
struct GridForward<'a> {
    network: &'a GridNetwork,
    grid: &'a Grid,
}

impl WithSimd for GridForward<'_> {
    type Output = Vec<f32>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> Self::Output {
        let Self { network, grid } = self;
        let [first, second, third] = &network.convolutions[..] else { unreachable!("there are three") };
        let values = convolve::<32>(grid.cells(), first);
        let values = convolve::<16>(&values, second);
        let mut values = convolve::<8>(&values, third);
        for (n, layer) in network.dense.iter().enumerate() {
            if n > 0 {
                rectify(&mut values);
            }
            let n_in = values.len();
            values = layer.rows(&values, n_in);
        }
        values
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::layers::{slow_convolution, slow_dense, slow_pool};
    use crate::weights::tests::{file, tensors};
    use nextview::geometry::random::Random;

    /// The layers of NBV-Net and of NBV regression.
    fn layouts() -> [NetworkLayout; 2] {
        [crate::nbv_net::layout(), crate::nbv_regression::layout()]
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

    fn slow_outputs(layers: &[Layer], grid: &Grid) -> Vec<f32> {
        let mut values = grid.cells().to_vec();
        for (layer, side) in layers.iter().zip([32, 16, 8]) {
            values = slow_pool(&slow_convolution(&values, side, layer), side);
        }
        for (n, layer) in layers[3..].iter().enumerate() {
            values = slow_dense(&values, layer);
            if n + 4 < layers.len() {
                values.iter_mut().for_each(|value| *value = value.max(0.0));
            }
        }
        values
    }

    #[test]
    fn computes_what_the_slow_twin_computes_to_the_bit() {
        for layout in layouts() {
            for seed in 0..4 {
                let (file, grid) = (file(&tensors(seed, &layout)), grid(seed));
                let found = GridNetwork::read(&file, &layout).unwrap().outputs(&grid);
                assert_eq!(
                    found,
                    slow_outputs(&weights::read(&file, &layout).unwrap(), &grid),
                    "seed {seed}"
                );
                assert!(found.iter().any(|value| value.abs() > 1e-3), "{found:?}");
            }
        }
    }

    #[test]
    fn has_the_same_bits_with_all_instructions() {
        for layout in layouts() {
            let network = GridNetwork::read(&file(&tensors(5, &layout)), &layout).unwrap();
            let grid = grid(9);
            let bits = |values: Vec<f32>| values.into_iter().map(f32::to_bits).collect::<Vec<_>>();
            let scalar = GridForward { network: &network, grid: &grid }.with_simd(pulp::Scalar::new());
            assert_eq!(bits(scalar), bits(network.outputs(&grid)));
        }
    }

    #[test]
    fn huge_weights_do_no_harm() {
        for layout in layouts() {
            let mut network = GridNetwork::read(&file(&tensors(1, &layout)), &layout).unwrap();
            network.dense.iter_mut().flat_map(Dense::weight_mut).for_each(|weight| *weight *= 1e30);
            network.outputs(&grid(1));
        }
    }
}
