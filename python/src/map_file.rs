//! OctoMap files as dense grids.

use crate::arrays::readonly;
use crate::errors::{exception, input_error};
use crate::model;
use crate::values::numbers;
use crate::watch::compute;
use glam::{DVec3, IVec3, UVec3};
use nextview::Cancel;
use nextview::geometry::{Lattice, VoxelBlock};
use nextview::map::{LogOdds, SensorModel, Snapshot};
use nextview_octomap::Octree;
use nextview_scan::files::{self, Overwrite};
use nextview_scan::{Fault, Faults, SavedMap};
use numpy::{Element, PyArray3, PyUntypedArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::path::{Path, PathBuf};

/// Maximum number of voxels of a grid: 320 MB of states and probabilities.
const MAX_VOXELS: usize = 1 << 26;

/// Reads the known part of an OctoMap file.
#[pyfunction]
pub fn read_map(py: Python<'_>, path: PathBuf) -> PyResult<Bound<'_, PyDict>> {
    model::map(py, &compute(py, &Cancel::default(), || Ok(read(&path)?))?)
}

fn read(path: &Path) -> Result<Snapshot, Fault> {
    let octree = SavedMap::read_octree(path)?;
    known(&octree).map_err(|fault| fault.in_file(path))
}

fn known(octree: &Octree) -> Result<Snapshot, Fault> {
    // A leaf may stand for more voxels than any grid has.
    let leaves = || octree.leaves().filter(|leaf| leaf.log_odds != 0.0);
    let min = leaves().map(|leaf| leaf.min).reduce(IVec3::min);
    let max = leaves().map(|leaf| leaf.max()).reduce(IVec3::max);
    let (Some(min), Some(max)) = (min, max) else {
        return Err(Fault::data("contains no measured voxel, expected at least one"));
    };
    let dims = (max - min + 1).as_uvec3();
    let is_small = dims.as_u64vec3().element_product() <= MAX_VOXELS as u64;
    let block = is_small.then(|| VoxelBlock::new(min, dims)).flatten().ok_or_else(|| {
        let fault = Fault::data(format!(
            "spans {} x {} x {} voxels, expected at most {MAX_VOXELS} in all for a dense grid",
            dims.x, dims.y, dims.z
        ));
        fault.with_remedy("cut the map to the part around the object")
    })?;
    let map = octree.to_map(SensorModel::default(), MAX_VOXELS)?;
    Ok(map.snapshot(block))
}

/// Writes a grid as `.ot` or `.bt`.
#[pyfunction]
#[pyo3(signature = (path, occupancy, probability, origin_m, voxel_size_m, force))]
pub fn write_map(
    py: Python<'_>,
    path: PathBuf,
    occupancy: &Bound<'_, PyAny>,
    probability: &Bound<'_, PyAny>,
    origin_m: &Bound<'_, PyAny>,
    voxel_size_m: f64,
    force: bool,
) -> PyResult<()> {
    let (occupancy, shape) = grid::<u8>("occupancy", occupancy, "uint8")?;
    let (probability, other) = grid::<f32>("probability", probability, "float32")?;
    if shape != other {
        let shapes = format!("{shape:?} and {other:?}");
        return Err(input_error(py, format!("`occupancy` and `probability` have the shapes {shapes}")));
    }
    let corner = numbers("origin_m", origin_m, |shape| shape == [3], "3 numbers, metres")?;
    let origin = key_of(DVec3::from_slice(&corner), voxel_size_m).map_err(|fault| exception(py, fault))?;
    // Sequentially: both may share memory.
    let states = readonly("occupancy", occupancy)?.as_array().to_owned();
    let probability = readonly("probability", probability)?;
    let measured = states.indexed_iter().zip(probability.as_array()).filter(|((_, state), _)| **state != 0);
    let voxels: Vec<(IVec3, f32)> = measured
        .map(|(((x, y, z), _), p)| (origin + UVec3::new(x as u32, y as u32, z as u32).as_ivec3(), *p))
        .collect();
    compute(py, &Cancel::default(), || write(&path, voxels, voxel_size_m, force))
}

/// Returns the array and its shape, if it is no larger than the maximum for reading maps.
fn grid<'a, 'py, T: Element>(
    name: &str,
    value: &'a Bound<'py, PyAny>,
    kind: &str,
) -> PyResult<(&'a Bound<'py, PyArray3<T>>, &'a [usize])> {
    let py = value.py();
    let Ok(array) = value.cast::<PyArray3<T>>() else {
        return Err(input_error(py, format!("`{name}`: expected a grid of X x Y x Z of {kind}")));
    };
    let n_voxels = array.shape().iter().try_fold(1_usize, |n, length| n.checked_mul(*length));
    if n_voxels.is_none_or(|n| n > MAX_VOXELS) {
        let expected = format!("expected at most {MAX_VOXELS} voxels in all");
        return Err(input_error(py, format!("`{name}` has the shape {:?}, {expected}", array.shape())));
    }
    Ok((array, array.shape()))
}

/// The voxel with this lowest corner.
fn key_of(corner: DVec3, voxel_size: f64) -> Result<IVec3, Fault> {
    let lattice = Lattice::new(voxel_size)?;
    let place = lattice.to_voxels(corner);
    let is_near = place.is_finite() && place.abs().max_element() < 1e9;
    let is_corner = is_near && (place - place.round()).abs().max_element() < 1e-6;
    if is_corner {
        return Ok(place.round().as_ivec3());
    }
    let expected = format!("multiples of the voxel size, {voxel_size}, as in every OctoMap");
    Err(Fault::of_value("origin_m", corner, expected))
}

fn write(path: &Path, voxels: Vec<(IVec3, f32)>, voxel_size: f64, force: bool) -> Result<(), Faults> {
    let is_ot = match path.extension().and_then(|extension| extension.to_str()) {
        Some("ot") => true,
        Some("bt") => false,
        _ => {
            let problem = format!("`path` is {}, expected a name that ends in .ot or .bt", path.display());
            return Err(Fault::request(problem).into());
        }
    };
    if let Some((_, p)) = voxels.iter().find(|(_, p)| !(*p > 0.0 && *p < 1.0)) {
        return Err(
            Fault::of_value("probability", p, "above 0 and below 1 where a voxel was measured").into()
        );
    }
    let log_odds = |(key, p): (IVec3, f32)| (key, LogOdds::from_probability(p.into()).0);
    let octree = Octree::from_voxels(voxel_size, voxels.into_iter().map(log_odds))?.pruned();
    let rule = Overwrite::forced(force);
    Ok(files::write(path, &rule, |writer| match is_ot {
        true => Ok(octree.write_ot(writer)?),
        false => Ok(octree.write_bt(writer)?),
    })?)
}
