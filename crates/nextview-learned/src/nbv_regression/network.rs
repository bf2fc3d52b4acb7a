use crate::grid::Grid;
use crate::grid_network::{self, GridNetwork, N_FEATURES};
use crate::weights::{NetworkLayout, WeightsError};
use glam::DVec3;

/// The network: maps a [`Grid`] to the direction of the next view.
///
/// The convolutions of [NBV-Net](crate::nbv_net::Network), then fully connected layers of 500, 100 and 3
/// units, rectified except the last. Every number is computed in the same order of operations on every CPU,
/// by one thread, so the results have the same bits.
///
/// ```
/// use nextview_learned::Grid;
/// use nextview_learned::nbv_regression::Network;
///
/// let nothing_known = Grid::from_bytes(&[127; Grid::N_CELLS]).unwrap();
/// assert!(Network::default().direction(&nothing_known).is_normalized());
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Network(GridNetwork);

/// Units before, between and after the fully connected layers.
const UNITS: [usize; 4] = [N_FEATURES, 500, 100, 3];

/// The library's weights; `docs/methods/nbv-regression.md` describes the training.
const WEIGHTS: &[u8] = include_bytes!("../../weights/nbv_regression.safetensors");

/// The layers, named like those of NBV-Net.
pub(crate) fn layout() -> NetworkLayout {
    grid_network::layout("NBV regression", &UNITS)
}

impl Default for Network {
    fn default() -> Self {
        Self::from_safetensors(WEIGHTS).expect("the library's own weights are whole")
    }
}

impl Network {
    /// Creates the network from the content of a safetensors file: the tensors `conv1.weight` to `fc3.bias`,
    /// in single or half precision.
    pub fn from_safetensors(file: &[u8]) -> Result<Self, WeightsError> {
        GridNetwork::read(file, &layout()).map(Self)
    }

    /// Returns the direction of the next view from the middle of the box, a unit vector: the three outputs
    /// divided by their norm. Upwards if the norm is zero.
    pub fn direction(&self, grid: &Grid) -> DVec3 {
        let outputs = self.outputs(grid).map(f64::from);
        DVec3::from_array(outputs).try_normalize().unwrap_or(DVec3::Z)
    }

    /// The values of the last layer.
    pub(crate) fn outputs(&self, grid: &Grid) -> [f32; 3] {
        self.0.outputs(grid).try_into().expect("three units")
    }
}
