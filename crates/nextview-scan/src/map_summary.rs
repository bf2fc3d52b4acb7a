//! What a saved map knows, and its other forms.

use crate::{Fault, SavedMap, files};
use glam::{DVec3, IVec3};
use nextview::geometry::{Aabb, Lattice};
use nextview::map::octree::TreeKind;
use nextview::map::{LogOdds, Octree, entropy};
use serde::Serialize;
use std::f64::consts::LN_2;
use std::io::Write;
use std::path::Path;

/// What a map knows, counted with the bounds of the paper's authors: a voxel is occupied above P = 0.65, free
/// below 0.45, and unknown in between or where nothing was measured.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MapSummary {
    /// Kind of the octree, as OctoMap names it.
    pub kind: &'static str,
    /// Edge of the smallest voxels.
    pub voxel_size_m: f64,
    /// Nodes of the octree.
    pub nodes: usize,
    /// Leaves of the octree.
    pub leaves: usize,
    /// Voxels with a value.
    pub measured_voxels: u64,
    /// Voxels above P = 0.65.
    pub occupied_voxels: u64,
    /// Voxels below P = 0.45.
    pub free_voxels: u64,
    /// In a box: all its other voxels. Without: measured voxels that are neither occupied nor free.
    pub unknown_voxels: u64,
    /// Corners of the box around all counted leaves; none if there are none.
    pub bounds_m: Option<[[f64; 3]; 2]>,
    /// Sum over the counted voxels; a voxel never measured has ln 2.
    pub entropy_nats: f64,
}

/// Bounds on P(occupied) of the paper's authors.
const OCCUPIED_ABOVE: f64 = 0.65;
const FREE_BELOW: f64 = 0.45;

/// Voxels from the origin to the end of an OctoMap, whose keys have 16 bits.
const OCTOMAP_REACH: f64 = 32768.0;

impl MapSummary {
    /// Counts the whole map, or only voxels whose centre lies in this cube.
    pub fn new(octree: &Octree, cube: Option<&Aabb>) -> Result<Self, Fault> {
        let lattice = Lattice::new(octree.voxel_size())?;
        let cube = cube.map(|cube| keys_inside(octree, &lattice, cube)).transpose()?;
        let mut summary = Self {
            kind: match octree.kind() {
                TreeKind::OcTree => "OcTree",
                TreeKind::ColorOcTree => "ColorOcTree",
            },
            voxel_size_m: octree.voxel_size(),
            nodes: octree.n_nodes(),
            leaves: octree.n_leaves(),
            measured_voxels: 0,
            occupied_voxels: 0,
            free_voxels: 0,
            unknown_voxels: 0,
            bounds_m: None,
            entropy_nats: 0.0,
        };
        let (mut low, mut high) = (IVec3::MAX, IVec3::MIN);
        for leaf in octree.leaves() {
            let (min, max) = (leaf.min, leaf.min + leaf.edge() as i32 - 1);
            let Some((min, max)) = overlap(cube, min, max) else { continue };
            let n_voxels = (max - min + 1).as_u64vec3().element_product();
            let p = LogOdds(leaf.log_odds).probability();
            summary.measured_voxels += n_voxels;
            *summary.count(p) += n_voxels;
            summary.entropy_nats += n_voxels as f64 * entropy(p);
            (low, high) = (low.min(min), high.max(max));
        }
        if let Some((min, max)) = cube {
            let n_voxels = (max - min + 1).as_u64vec3().element_product();
            let unmeasured = n_voxels - summary.measured_voxels;
            summary.unknown_voxels += unmeasured;
            summary.entropy_nats += unmeasured as f64 * LN_2;
        }
        let corner = |key: IVec3| (key.as_dvec3() * lattice.voxel_size()).to_array();
        summary.bounds_m = (summary.measured_voxels > 0).then(|| [corner(low), corner(high + 1)]);
        Ok(summary)
    }

    fn count(&mut self, p: f64) -> &mut u64 {
        if p > OCCUPIED_ABOVE {
            &mut self.occupied_voxels
        } else if p < FREE_BELOW {
            &mut self.free_voxels
        } else {
            &mut self.unknown_voxels
        }
    }
}

/// The lowest and the highest voxel in a cube, which must lie in the space of the map.
fn keys_inside(octree: &Octree, lattice: &Lattice, cube: &Aabb) -> Result<(IVec3, IVec3), Fault> {
    let reach = OCTOMAP_REACH * lattice.voxel_size();
    let origin = octree.origin().as_dvec3() * lattice.voxel_size();
    if (cube.min - origin).abs().max((cube.max - origin).abs()).max_element() > reach {
        let place = match octree.origin() {
            IVec3::ZERO => "the origin".to_owned(),
            _ => format!("{origin} m"),
        };
        return Err(Fault::request(format!(
            "`box` goes beyond the space of the map, {reach:.3} m from {place} on each axis"
        )));
    }
    let none = || Fault::request("`box` holds no voxel centre, expected a cube of at least one voxel");
    lattice.keys_inside(cube).ok_or_else(none)
}

/// The part of a leaf inside the cube.
fn overlap(cube: Option<(IVec3, IVec3)>, min: IVec3, max: IVec3) -> Option<(IVec3, IVec3)> {
    let (min, max) = cube.map_or((min, max), |(low, high)| (min.max(low), max.min(high)));
    min.cmple(max).all().then_some((min, max))
}

/// Maximum number of voxels that merged leaves may become when they are written one by one.
const MAX_VOXELS: usize = 50_000_000;

/// Writes a map in the form that the target's name asks for: `.ot`, `.bt`, or the centres of its occupied
/// voxels as `.ply`.
pub fn convert_map(from: &Path, to: &Path) -> Result<(), Fault> {
    let extension = to.extension().map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default();
    let write = |octree: &Octree, bytes: &mut Vec<u8>| -> Result<(), Fault> {
        match extension.as_str() {
            "ot" => Ok(octree.write_ot(bytes)?),
            "bt" => Ok(octree.write_bt(bytes)?),
            _ => Ok(nextview::surface::write_points(bytes, &occupied_centers(octree)?)?),
        }
    };
    if !["ot", "bt", "ply"].contains(&extension.as_str()) {
        let name = to.display();
        return Err(Fault::request(format!(
            "{name}: unknown format, expected a file name that ends in .ot, .bt or .ply"
        )));
    }
    let mut bytes = Vec::new();
    write(&SavedMap::read_octree(from)?, &mut bytes).map_err(|fault| fault.in_file(from))?;
    files::write(to, |writer| Ok(writer.write_all(&bytes)?))
}

fn occupied_centers(octree: &Octree) -> Result<Vec<DVec3>, Fault> {
    let lattice = Lattice::new(octree.voxel_size())?;
    let expanded = octree.expanded(MAX_VOXELS)?;
    let occupied = expanded.leaves().filter(|leaf| leaf.log_odds > 0.0);
    Ok(occupied.map(|leaf| lattice.center(leaf.min)).collect())
}
