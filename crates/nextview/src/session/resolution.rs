use crate::Error;
use crate::checked::{check_range, checked_when_read};
use serde::{Deserialize, Serialize};

/// Planning from coarse voxels to fine ones: the paper's algorithm 1.
///
/// After each frame, while the entropy of the map in the current voxels is below `q_thresh` of that of an
/// unknown map (eqs. 8, 9), planning continues in voxels half the size, down to the finest. There,
/// [`StopConfig::entropy_share`](super::StopConfig::entropy_share) ends the scan. Algorithm 1 uses 0.5 for
/// both.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields, remote = "Self")]
pub struct MultiResolutionConfig {
    /// Whether planning begins in coarser voxels. Default: no.
    pub enabled: bool,
    /// Initial voxel size, metres: the finest times a power of two. Default: the coarsest that fits at least
    /// 12 voxels along the first box (the paper, section IV.C).
    #[serde(rename = "coarsest_voxel_size_m", skip_serializing_if = "Option::is_none")]
    pub coarsest_voxel_size: Option<f64>,
    /// Share of an unknown map's entropy below which the voxels are halved, 0..=1; the paper's q_thresh.
    /// Default 0.5.
    pub q_thresh: f64,
}

/// Minimum number of voxels along the edge of the box in the coarsest map.
const LEAST_VOXELS: f64 = 12.0;

/// Maximum number of halvings: a cube of 12 voxels becomes one of 400,000.
const MOST_HALVINGS: u32 = 15;

impl Default for MultiResolutionConfig {
    fn default() -> Self {
        Self { enabled: false, coarsest_voxel_size: None, q_thresh: 0.5 }
    }
}

checked_when_read!(MultiResolutionConfig);

impl MultiResolutionConfig {
    /// Returns the defaults, enabled.
    pub fn enabled() -> Self {
        Self { enabled: true, ..Self::default() }
    }

    /// Fails on the first value out of range, whether enabled or not.
    pub fn check(&self) -> Result<(), Error> {
        check_range("q_thresh", self.q_thresh, 0.0..=1.0, "a number in 0..=1")?;
        match self.coarsest_voxel_size {
            Some(size) if !(size > 0.0 && size.is_finite()) => {
                Err(Error::invalid("coarsest_voxel_size_m", size, "a positive number of metres"))
            }
            _ => Ok(()),
        }
    }

    /// As [`check`](Self::check), and fails unless the coarsest voxels halve to the finest.
    pub(super) fn check_for(&self, finest: f64) -> Result<(), Error> {
        self.check()?;
        match self.coarsest_voxel_size {
            Some(coarsest) if halvings(coarsest, finest).is_none() => Err(Error::invalid(
                "coarsest_voxel_size_m",
                coarsest,
                "the finest voxel size times 1, 2, 4, 8, ... or 32768",
            )),
            _ => Ok(()),
        }
    }

    /// Returns the number of halvings from the coarsest to the finest voxels in a box with this edge
    /// (metres).
    pub(super) fn n_halvings(&self, finest: f64, edge: f64) -> u32 {
        let stated = self.coarsest_voxel_size.and_then(|coarsest| halvings(coarsest, finest));
        let fits = |n: &u32| edge / (finest * 2_f64.powi(*n as i32)) >= LEAST_VOXELS;
        stated.unwrap_or_else(|| (1..=MOST_HALVINGS).take_while(fits).last().unwrap_or(0))
    }
}

/// Returns the number of halvings from `coarsest` to `finest`, up to rounding; `None` if no number fits.
fn halvings(coarsest: f64, finest: f64) -> Option<u32> {
    let is_power = |n: &u32| (coarsest / finest / 2_f64.powi(*n as i32) - 1.0).abs() < 1e-9;
    (0..=MOST_HALVINGS).find(is_power)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn begins_where_twelve_voxels_fit() {
        let rule = MultiResolutionConfig::default();
        for (edge, expected) in [(0.05, 0), (0.239, 0), (0.2401, 1), (0.479, 1), (0.4801, 2), (1e9, 15)] {
            assert_eq!(rule.n_halvings(0.01, edge), expected, "{edge}");
        }
        let stated = MultiResolutionConfig { coarsest_voxel_size: Some(0.04), ..rule };
        assert_eq!(stated.n_halvings(0.01, 0.1), 2);
    }

    #[test]
    fn refuses_what_is_no_power_of_two_and_no_share() {
        let check = |coarsest_voxel_size, q_thresh| {
            let rule =
                MultiResolutionConfig { coarsest_voxel_size, q_thresh, ..MultiResolutionConfig::enabled() };
            rule.check_for(0.005).map_err(|e| e.to_string())
        };
        for size in [0.005, 0.01, 0.02, 0.04] {
            assert_eq!(check(Some(size), 0.0), Ok(()));
        }
        for size in [0.0025, 0.015, 0.0, -0.01, f64::NAN, f64::INFINITY] {
            assert!(check(Some(size), 0.5).unwrap_err().contains("coarsest_voxel_size"), "{size}");
        }
        for q_thresh in [-0.1, 1.1, f64::NAN] {
            assert!(check(None, q_thresh).unwrap_err().contains("q_thresh"));
        }
    }
}
