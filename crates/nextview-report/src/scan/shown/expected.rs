//! Unseen surface expected by the prior.

use super::candidate_gain::candidate_gains;
use crate::scan::scan_copy::ScanCopy;
use nextview::map::{Occupancy, Snapshot};
use nextview::prior::{SurfaceEstimate, SurfacePrior, coarse_enough};
use nextview::{Cancel, Error};
use nextview_model::{SurfaceMesh, surface_nets};

/// A shell around the unseen voxels that probably hold surface, and the expected gain of each candidate.
pub(super) fn of_scan(scan: &ScanCopy) -> Result<(SurfaceMesh, Vec<f64>), Error> {
    // A cancelled scan has a page, too.
    let cancel = &Cancel::default();
    let Some(snapshot) = &scan.snapshot else { return Ok(Default::default()) };
    let snapshot = coarse_enough(snapshot, cancel)?;
    let estimate = SurfacePrior::default().estimate(&snapshot, cancel)?;
    Ok((shell(&snapshot, &estimate), candidate_gains(scan, &snapshot, &estimate)?))
}

/// A shell around the unseen voxels that probably hold surface themselves or in one of their six neighbours:
/// a sheet of surface is often certain where no single voxel is.
///
/// It is open towards measured surface, which it would only cover.
fn shell(snapshot: &Snapshot, estimate: &SurfaceEstimate) -> SurfaceMesh {
    let (occupancy, block) = (snapshot.occupancy(), snapshot.block());
    let mut empty = vec![1.0; occupancy.len()];
    for (i, &voxel) in estimate.voxels().iter().enumerate() {
        if occupancy[voxel as usize] == Occupancy::Unknown {
            empty[voxel as usize] = 1.0 - f64::from(estimate.stops(i));
        }
    }
    surface_nets(&snapshot.lattice(), &block, |voxel| match occupancy[voxel] {
        Occupancy::Occupied => None,
        Occupancy::Free => Some(0.5),
        Occupancy::Unknown => {
            Some(empty[voxel] * block.neighbors(voxel).map(|next| empty[next]).product::<f64>() - 0.5)
        }
    })
}
