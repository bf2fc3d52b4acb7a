use super::values;
use crate::{Failure, stdout};
use clap::{Args, Subcommand};
use nextview::geometry::Aabb;
use nextview_scan::files::Overwrite;
use nextview_scan::{MapSummary, SavedMap, convert_map};
use std::path::PathBuf;

/// Summarise and convert OctoMap files (.ot, .bt).
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

/// Summarise a map: kind, voxel size, leaves, voxels by state, bounding box, entropy.
///
/// A voxel counts as occupied if P > 0.65, as free if P < 0.45, and as unknown otherwise: never measured, or
/// measured without a clear result, such as one hit and one miss. These are the bounds of the paper's
/// authors; `measured_voxels` counts the voxels with a value in the map. Entropy is in nats; a voxel never
/// measured has ln 2.
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
/// .ot to .ot and .bt to .bt keep every byte; .ot to .bt keeps only occupied (P >= 0.5) and free, as
/// OctoMap's own tools do.
#[derive(Debug, Args)]
#[command(after_help = "Example:\n  nextview map convert map.ot occupied.ply")]
pub(super) struct ConvertArgs {
    /// The map to read, .ot or .bt
    from: PathBuf,
    /// The file to write, .ot, .bt or .ply
    to: PathBuf,
    /// Replace the file to write if it exists
    #[arg(long)]
    force: bool,
}

impl InfoArgs {
    fn run(self) -> Result<(), Failure> {
        let summary = MapSummary::new(&SavedMap::read_octree(&self.file)?, self.cube.as_ref())?;
        if self.json {
            return stdout::print(serde_json::to_string(&summary).map_err(Failure::data)? + "\n");
        }
        stdout::print(to_text(&summary, self.cube.is_some()))
    }
}

impl ConvertArgs {
    fn run(self) -> Result<(), Failure> {
        Ok(convert_map(&self.from, &self.to, Overwrite::forced(self.force))?)
    }
}

fn to_text(summary: &MapSummary, in_box: bool) -> String {
    let unknown = if in_box { "other voxels of the box" } else { "measured, but 0.45 <= P <= 0.65" };
    let bounds = summary.bounds_m.map_or("none: nothing measured".to_owned(), |[low, high]| {
        format!("{} to {} m", triple(low), triple(high))
    });
    let rows = [
        ("kind", summary.kind.to_owned()),
        ("voxel size", format!("{} m", summary.voxel_size_m)),
        ("nodes", summary.nodes.to_string()),
        ("leaves", summary.leaves.to_string()),
        ("measured voxels", summary.measured_voxels.to_string()),
        ("occupied voxels", format!("{}  (P > 0.65)", summary.occupied_voxels)),
        ("free voxels", format!("{}  (P < 0.45)", summary.free_voxels)),
        ("unknown voxels", format!("{}  ({unknown})", summary.unknown_voxels)),
        ("bounds", bounds),
        ("entropy", format!("{:.2} nats", summary.entropy_nats)),
    ];
    rows.iter().map(|(label, value)| format!("{label:<16} {value}\n")).collect()
}

fn triple([x, y, z]: [f64; 3]) -> String {
    format!("({x:.4}, {y:.4}, {z:.4})")
}
