use super::values::{named, positive};
use crate::{Failure, stdout};
use clap::Args;
use nextview::Cancel;
use nextview_inspect::{INSPECTION_FILES, InspectionConfig, inspect, write_inspection};
use nextview_scan::UnitName;
use nextview_scan::files::{Overwrite, ResultFolder};
use nextview_sim::mesh;
use std::path::PathBuf;

/// Compare a scanned part with its CAD model.
///
/// Reads the cloud of a scan, finds where the part stood, and writes how far every point is from the model,
/// how sure that is, and where the part deviates. Triangles of the model run counter-clockwise seen from
/// outside.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub(super) struct InspectArgs {
    /// The folder of the scan
    dir: PathBuf,
    /// The CAD model: .ply .obj .stl .off .gltf .glb
    #[arg(long, value_name = "MESH")]
    reference: PathBuf,
    /// Unit of the CAD model's file
    #[arg(long, value_parser = named::<UnitName>(), default_value = "auto")]
    unit: UnitName,
    /// Deviations up to this are none
    #[arg(long, value_name = "MM", value_parser = positive, default_value = "0.5", allow_negative_numbers = true)]
    tolerance_mm: f64,
    /// Radius of the patches over which deviations are averaged: smaller ones show smaller defects, larger
    /// ones have less noise [default: 2, or more where the cloud's points are far apart]
    #[arg(long, value_name = "MM", value_parser = positive, allow_negative_numbers = true)]
    patch_mm: Option<f64>,
    /// The folder for inspection.json and deviation.ply
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Replace files that are in it
    #[arg(long)]
    force: bool,
    /// Print inspection.json
    #[arg(long)]
    json: bool,
}

const EXAMPLES: &str = "\
Examples:
  nextview scan --frames part.mcap --out part
  nextview inspect part --reference part.stl --unit mm --tolerance-mm 0.5 --out part-inspection";

impl InspectArgs {
    pub fn run(self) -> Result<(), Failure> {
        let rule = Overwrite::forced(self.force).but(vec![self.reference.clone()]);
        let mut folder = ResultFolder::begin(&self.out, INSPECTION_FILES, rule)?;
        let (reference, scaling) = mesh::load(&self.reference)?.to_metres(self.unit.into())?;
        eprintln!("note: {}: {scaling}", self.reference.display());
        let config = InspectionConfig { tolerance_mm: self.tolerance_mm, patch_mm: self.patch_mm };
        let name = self.reference.display().to_string();
        let inspection = inspect(&self.dir, &reference, &name, config, &Cancel::default())?;
        write_inspection(&mut folder, &inspection)?;
        folder.publish()?;
        stdout::print(match self.json {
            true => serde_json::to_string(&inspection.record).map_err(Failure::data)? + "\n",
            false => inspection.record.text() + &format!("\nresults in {}\n", self.out.display()),
        })
    }
}
