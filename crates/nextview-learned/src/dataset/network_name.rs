use crate::grid::Grid;
use crate::nbv_net;
use crate::pc_nbv::{self, Cloud};
use glam::DVec3;
use nextview::geometry::sphere;
use nextview_sim::random_object::seeds;
use serde::{Deserialize, Serialize};
use std::ops::Range;

/// The network that a data set is for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum NetworkName {
    /// NBV-Net: a grid, and 14 views.
    #[default]
    NbvNet,
    /// NBV regression: a grid, and [128 views](Self::N_REGRESSION_VIEWS) all around.
    NbvRegression,
    /// PC-NBV: points, the visited views, and 33 views.
    PcNbv,
}

impl std::fmt::Display for NetworkName {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::NbvNet => "nbv-net",
            Self::NbvRegression => "nbv-regression",
            Self::PcNbv => "pc-nbv",
        })
    }
}

impl NetworkName {
    /// Number of views of a sample for NBV regression, on a Fibonacci sphere.
    pub const N_REGRESSION_VIEWS: usize = 128;

    /// The directions of the views with gains in a sample.
    pub(super) fn directions(self) -> Vec<DVec3> {
        let n = Self::N_REGRESSION_VIEWS;
        match self {
            Self::NbvNet => nbv_net::views::DIRECTIONS.to_vec(),
            Self::NbvRegression => (0..n).map(|view| sphere::fibonacci(view, n)).collect(),
            Self::PcNbv => pc_nbv::views::DIRECTIONS.to_vec(),
        }
    }

    /// The seeds of its random objects.
    pub(super) fn seeds(self) -> Range<u64> {
        match self {
            Self::NbvNet => seeds::NBV_NET,
            Self::NbvRegression => seeds::NBV_REGRESSION,
            Self::PcNbv => seeds::PC_NBV,
        }
    }

    /// The fields of the network's input, in NumPy's notation.
    pub(super) fn input_fields(self) -> String {
        let (side, points, views) = (Grid::SIDE, Cloud::N_POINTS, pc_nbv::views::N_VIEWS);
        match self {
            Self::NbvNet | Self::NbvRegression => format!("('grid', '|u1', ({side}, {side}, {side}))"),
            Self::PcNbv => {
                format!(
                    "('surface', '<u4'), ('visited', '|u1', ({views},)), ('points', '<f4', ({points}, 3))"
                )
            }
        }
    }
}
