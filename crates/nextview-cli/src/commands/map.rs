use super::values;
use crate::{Failure, files, stdout};
use clap::{Args, Subcommand};
use glam::{DVec3, IVec3};
use nextview::geometry::{Aabb, Lattice, VoxelBlock};
use nextview::map::octree::TreeKind;
use nextview::map::{LogOdds, Octree, entropy};
use serde::Serialize;
use std::f64::consts::LN_2;
use std::io::Write;
use std::path::{Path, PathBuf};

/// Look into OctoMap files (.ot, .bt) and convert them.
#[derive(Debug, Subcommand)]
#[command(after_help = "Examples:\n  nextview map info map.ot\n  nextview map convert map.ot occupied.ply")]
pub(super) enum MapCommand {
    Info(InfoArgs),
    Convert(ConvertArgs),
}

impl MapCommand {
    pub fn run(self) -> Result<(), Failure> {
        match self {
            Self::Info(args) => args.run(),
            Self::Convert(args) => args.run(),
        }
    }
}

/// Show what a map knows: kind, voxel size, leaves, voxels by state, bounding box, entropy.
///
/// A voxel counts as occupied if P > 0.65, as free if P < 0.45, and as unknown otherwise: never measured, or measured
/// without a clear result, such as one hit and one miss. These are the bounds of the paper's authors; `measured_voxels` counts
/// the voxels that the map has a value for. Entropy is in nats, and a voxel never measured has ln 2.
#[derive(Debug, Args)]
#[command(after_help = "Example:\n  nextview map info map.ot --box 0,0,0.05,0.1 --json")]
pub(super) struct InfoArgs {
    /// The map, .ot or .bt
    file: PathBuf,
    /// Count only voxels whose centre lies in this cube: its centre and half its edge, metres
    #[arg(long = "box", value_name = "CX,CY,CZ,HALF", value_parser = values::cube, allow_hyphen_values = true)]
    cube: Option<Aabb>,
    /// Print one JSON object
    #[arg(long)]
    json: bool,
}

/// Convert a map between .ot and .bt, or write the centres of its occupied voxels as .ply.
///
/// .ot to .ot and .bt to .bt keep every byte; .ot to .bt keeps occupied (P >= 0.5) and free only, as OctoMap's own
/// tools do.
#[derive(Debug, Args)]
#[command(after_help = "Example:\n  nextview map convert map.ot occupied.ply")]
pub(super) struct ConvertArgs {
    /// The map to read, .ot or .bt
    from: PathBuf,
    /// The file to write, .ot, .bt or .ply
    to: PathBuf,
}

pub(super) fn read(path: &Path) -> Result<Octree, Failure> {
    Octree::read(files::open(path)?).map_err(|e| Failure::from(e).in_file(path))
}

/// What `map info` tells.
#[derive(Debug, Serialize)]
struct Info {
    kind: &'static str,
    voxel_size_m: f64,
    nodes: usize,
    leaves: usize,
    measured_voxels: u64,
    occupied_voxels: u64,
    free_voxels: u64,
    /// In a box: all its other voxels. Without: measured voxels that are neither occupied nor free.
    unknown_voxels: u64,
    /// Corners of the box around all counted leaves; none if there are none.
    bounds_m: Option<[[f64; 3]; 2]>,
    entropy_nats: f64,
}

/// Bounds on P(occupied) of the paper's authors.
const OCCUPIED_ABOVE: f64 = 0.65;
const FREE_BELOW: f64 = 0.45;

/// Voxels from the origin to the end of an OctoMap, whose keys have 16 bits.
const OCTOMAP_REACH: f64 = 32768.0;

impl InfoArgs {
    fn run(self) -> Result<(), Failure> {
        let octree = read(&self.file)?;
        let info = Info::new(&octree, self.cube.as_ref())?;
        if self.json {
            return stdout::print(serde_json::to_string(&info).map_err(Failure::data)? + "\n");
        }
        stdout::print(info.to_text(self.cube.is_some()))
    }
}

impl Info {
    fn new(octree: &Octree, cube: Option<&Aabb>) -> Result<Self, Failure> {
        let lattice = Lattice::new(octree.voxel_size())?;
        let block = cube.map(|cube| block_inside(&lattice, cube)).transpose()?;
        let mut info = Self {
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
            let Some((min, max)) = overlap(block.as_ref(), min, max) else { continue };
            let n_voxels = (max - min + 1).as_u64vec3().element_product();
            let p = LogOdds(leaf.log_odds).probability();
            info.measured_voxels += n_voxels;
            *info.count(p) += n_voxels;
            info.entropy_nats += n_voxels as f64 * entropy(p);
            (low, high) = (low.min(min), high.max(max));
        }
        if let Some(block) = block {
            let unmeasured = block.n_voxels() as u64 - info.measured_voxels;
            info.unknown_voxels += unmeasured;
            info.entropy_nats += unmeasured as f64 * LN_2;
        }
        let corner = |key: IVec3| (key.as_dvec3() * lattice.voxel_size()).to_array();
        info.bounds_m = (info.measured_voxels > 0).then(|| [corner(low), corner(high + 1)]);
        Ok(info)
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

    fn to_text(&self, in_box: bool) -> String {
        let unknown = if in_box { "other voxels of the box" } else { "measured, but 0.45 <= P <= 0.65" };
        let bounds = self.bounds_m.map_or("none: nothing measured".to_owned(), |[low, high]| {
            format!("{} to {} m", triple(low), triple(high))
        });
        let rows = [
            ("kind", self.kind.to_owned()),
            ("voxel size", format!("{} m", self.voxel_size_m)),
            ("nodes", self.nodes.to_string()),
            ("leaves", self.leaves.to_string()),
            ("measured voxels", self.measured_voxels.to_string()),
            ("occupied voxels", format!("{}  (P > 0.65)", self.occupied_voxels)),
            ("free voxels", format!("{}  (P < 0.45)", self.free_voxels)),
            ("unknown voxels", format!("{}  ({unknown})", self.unknown_voxels)),
            ("bounds", bounds),
            ("entropy", format!("{:.2} nats", self.entropy_nats)),
        ];
        rows.iter().map(|(label, value)| format!("{label:<16} {value}\n")).collect()
    }
}

fn triple([x, y, z]: [f64; 3]) -> String {
    format!("({x:.4}, {y:.4}, {z:.4})")
}

/// The voxels in a cube, which must lie in the space of an OctoMap.
fn block_inside(lattice: &Lattice, cube: &Aabb) -> Result<VoxelBlock, Failure> {
    let reach = OCTOMAP_REACH * lattice.voxel_size();
    if cube.min.abs().max(cube.max.abs()).max_element() > reach {
        return Err(Failure::usage(format!(
            "--box goes beyond the space of the map, {reach:.3} m from the origin on each axis"
        )));
    }
    let none = || Failure::usage("--box holds no voxel centre, expected a cube of at least one voxel");
    lattice.block_inside(cube).ok_or_else(none)
}

/// The part of a leaf inside the block.
fn overlap(block: Option<&VoxelBlock>, min: IVec3, max: IVec3) -> Option<(IVec3, IVec3)> {
    let (min, max) = block.map_or((min, max), |block| (min.max(block.min()), max.min(block.max())));
    min.cmple(max).all().then_some((min, max))
}

/// Most voxels that merged leaves may become when they are written out one by one.
const MAX_VOXELS: usize = 50_000_000;

impl ConvertArgs {
    fn run(self) -> Result<(), Failure> {
        let extension = self.to.extension().map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default();
        match extension.as_str() {
            "ot" => self.write(|octree, writer| Ok(octree.write_ot(writer)?)),
            "bt" => self.write(|octree, writer| Ok(octree.write_bt(writer)?)),
            "ply" => self.write(|octree, writer| {
                Ok(nextview::model::write_points(writer, &occupied_centers(octree)?)?)
            }),
            _ => Err(Failure::usage(format!(
                "{}: unknown format, expected a file name that ends in .ot, .bt or .ply",
                self.to.display()
            ))),
        }
    }

    fn write(&self, form: impl FnOnce(&Octree, &mut Vec<u8>) -> Result<(), Failure>) -> Result<(), Failure> {
        let mut bytes = Vec::new();
        form(&read(&self.from)?, &mut bytes).map_err(|failure| failure.in_file(&self.from))?;
        files::write(&self.to, |writer| Ok(writer.write_all(&bytes)?))
    }
}

fn occupied_centers(octree: &Octree) -> Result<Vec<DVec3>, Failure> {
    let lattice = Lattice::new(octree.voxel_size())?;
    let expanded = octree.expanded(MAX_VOXELS)?;
    let occupied = expanded.leaves().filter(|leaf| leaf.log_odds > 0.0);
    Ok(occupied.map(|leaf| lattice.center(leaf.min)).collect())
}
