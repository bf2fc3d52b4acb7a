use super::views::N_VIEWS;
use crate::grid::Grid;
use crate::grid_network::{self, GridNetwork, N_FEATURES};
use crate::weights::{NetworkLayout, WeightsError};

/// The network of the paper: maps a [`Grid`] to a number for each of the 14 views; larger is better.
///
/// Three 3D convolutions (10, 12 and 8 filters of 3 x 3 x 3 cells, zero padding), each followed by a
/// rectifier and max pooling over eight neighbours; then five fully connected layers of 1500, 500, 100, 50
/// and 14 units, rectified except the last. The authors' code also rectifies the last one, which separates
/// views no better and makes training harder.
///
/// Every number is computed in the same order of operations on every CPU, by one thread, so the results have
/// the same bits.
///
/// ```
/// use nextview_learned::Grid;
/// use nextview_learned::nbv_net::Network;
///
/// let nothing_known = Grid::from_bytes(&[127; Grid::N_CELLS]).unwrap();
/// assert_eq!(Network::default().logits(&nothing_known).len(), 14);
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Network(GridNetwork);

/// Units before, between and after the fully connected layers.
const UNITS: [usize; 6] = [N_FEATURES, 1500, 500, 100, 50, N_VIEWS];

/// The library's weights; `docs/methods/nbv-net.md` describes the training.
const WEIGHTS: &[u8] = include_bytes!("../../weights/nbv_net.safetensors");

/// The layers, by their names in the published network.
pub(crate) fn layout() -> NetworkLayout {
    grid_network::layout("NBV-Net", &UNITS)
}

impl Default for Network {
    fn default() -> Self {
        Self::from_safetensors(WEIGHTS).expect("the library's own weights are whole")
    }
}

impl Network {
    /// Creates the network from the content of a safetensors file: the tensors of the published network, by
    /// its names (`conv1.weight` to `fc5.bias`), in single or half precision.
    pub fn from_safetensors(file: &[u8]) -> Result<Self, WeightsError> {
        GridNetwork::read(file, &layout()).map(Self)
    }

    /// Returns a number for each view, whose exponential is proportional to the view's probability.
    pub fn logits(&self, grid: &Grid) -> [f32; N_VIEWS] {
        self.0.outputs(grid).try_into().expect("as many as views")
    }
}
