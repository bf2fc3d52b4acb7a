//! The content of a saved map, and its conversions.

use crate::files::{self, Overwrite};
use crate::{Fault, SavedMap};
use glam::{DVec3, IVec3};
use nextview::geometry::{Aabb, Lattice};
use nextview::map::{LogOdds, entropy};
use nextview_octomap::Octree;
use nextview_octomap::{Leaf, TreeKind};
use serde::Serialize;
use std::f64::consts::LN_2;
use std::path::Path;

/// The content of a map by the thresholds of the paper's authors: a voxel is occupied above P = 0.65, free
/// below 0.45, and unknown in between or where nothing was measured.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MapSummary {
    /// Kind of the octree in OctoMap's terms.
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
    /// With a box: all its other voxels. Without: measured voxels that are neither occupied nor free.
    pub unknown_voxels: u64,
    /// Corners of the bounding box of all counted leaves; `None` if there are none.
    pub bounds_m: Option<[[f64; 3]; 2]>,
    /// Sum over the counted voxels; an unmeasured voxel has ln 2.
    pub entropy_nats: f64,
}

/// Thresholds on P(occupied) of the paper's authors.
const OCCUPIED_ABOVE: f64 = 0.65;
const FREE_BELOW: f64 = 0.45;

/// Voxels from the origin to the end of an OctoMap, which has 16-bit keys.
const OCTOMAP_REACH: f64 = 32768.0;

impl MapSummary {
    /// Counts the whole map, or only voxels with their centre in this cube.
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
            let (lowest, highest) = cube.unwrap_or((leaf.min, leaf.max()));
            let Some((min, max)) = leaf.part_between(lowest, highest) else { continue };
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

/// The lowest and the highest voxel in a cube, which must lie within the map's extent.
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

/// Maximum number of voxels from expanding merged leaves.
const MAX_VOXELS: u64 = 50_000_000;

/// Writes a map in the format of the target's extension: `.ot`, `.bt`, or `.ply` for the centres of its
/// occupied voxels. The rule decides whether an existing target is replaced; the map itself never is.
pub fn convert_map(from: &Path, to: &Path, rule: Overwrite) -> Result<(), Fault> {
    let extension = to.extension().map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default();
    if !["ot", "bt", "ply"].contains(&extension.as_str()) {
        let name = to.display();
        return Err(Fault::request(format!(
            "{name}: unknown format, expected a file name that ends in .ot, .bt or .ply"
        )));
    }
    let rule = rule.but(vec![from.to_owned()]);
    rule.check_file(to)?;
    let octree = SavedMap::read_octree(from)?;
    let lattice = Lattice::new(octree.voxel_size()).map_err(|e| Fault::from(e).in_file(from))?;
    if extension == "ply" {
        check_expanded(&octree).map_err(|fault| fault.in_file(from))?;
    }
    files::write(to, &rule, |writer| match extension.as_str() {
        "ot" => Ok(octree.write_ot(writer)?),
        "bt" => Ok(octree.write_bt(writer)?),
        _ => Ok(nextview_model::write_points(writer, || occupied_centers(&octree, lattice))?),
    })
}

/// Fails if merged leaves expand to too many voxels.
fn check_expanded(octree: &Octree) -> Result<(), Fault> {
    let n_voxels: u64 = occupied(octree).map(|leaf| u64::from(leaf.edge()).pow(3)).sum();
    if n_voxels <= MAX_VOXELS {
        return Ok(());
    }
    let message = format!("has {n_voxels} occupied voxels, expected at most {MAX_VOXELS} to write as points");
    Err(Fault::data(message))
}

fn occupied(octree: &Octree) -> impl Iterator<Item = Leaf> {
    octree.leaves().filter(|leaf| leaf.log_odds > 0.0)
}

/// The centres of the occupied voxels in octant order, like the leaves. They are generated lazily: a leaf may
/// be millions of voxels.
fn occupied_centers(octree: &Octree, lattice: Lattice) -> impl Iterator<Item = DVec3> {
    occupied(octree).flat_map(move |leaf| {
        let n_voxels = u64::from(leaf.edge()).pow(3);
        (0..n_voxels).map(move |i| lattice.center(leaf.min + octants(i)))
    })
}

/// The position encoded by a number with interleaved bits of x, y and z, lowest first.
fn octants(number: u64) -> IVec3 {
    let coordinate = |axis: u32| (0..16).map(|bit| ((number >> (3 * bit + axis) & 1) << bit) as i32).sum();
    IVec3::new(coordinate(0), coordinate(1), coordinate(2))
}
