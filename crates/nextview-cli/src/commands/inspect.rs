use super::values::{named, positive};
use crate::{Failure, stdout};
use clap::Args;
use nextview::Cancel;
use nextview_inspect::{INSPECTION_FILES, InspectionConfig, inspect, reference_of, write_inspection};
use nextview_scan::UnitName;
use nextview_scan::files::{Overwrite, ResultFolder};
use std::path::PathBuf;

/// Compare a scanned part with its CAD model.
///
/// Reads the cloud of a scan, locates the part in it, and writes the distance of every point from the model,
/// its uncertainty, and the places where the part deviates. Triangles of the model must run counter-clockwise
/// seen from outside.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub(super) struct InspectArgs {
    /// The folder of the scan
    dir: PathBuf,
    /// The CAD model: .ply .obj .stl .off .gltf .glb [default: that of the scan]
    #[arg(long, value_name = "MESH")]
    reference: Option<PathBuf>,
    /// Unit of the CAD model's file [default: that of the scan, or auto]
    #[arg(long, value_parser = named::<UnitName>())]
    unit: Option<UnitName>,
    /// Deviations up to this are accepted
    #[arg(long, value_name = "MM", value_parser = positive, default_value = "0.5", allow_negative_numbers = true)]
    tolerance_mm: f64,
    /// Radius of the patches over which deviations are averaged: smaller ones show smaller defects, larger
    /// ones have less noise [default: 2, or more where the cloud's points are far apart]
    #[arg(long, value_name = "MM", value_parser = positive, allow_negative_numbers = true)]
    patch_mm: Option<f64>,
    /// The folder for inspection.json and deviation.ply
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Replace existing files
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
        let reference = reference_of(&self.dir, self.reference, self.unit)?;
        let rule = Overwrite::forced(self.force).but(vec![reference.mesh.clone()]);
        let mut folder = ResultFolder::begin(&self.out, INSPECTION_FILES, rule)?;
        let config = InspectionConfig { tolerance_mm: self.tolerance_mm, patch_mm: self.patch_mm };
        let inspection = inspect(&self.dir, &reference, config, &Cancel::default())?;
        eprintln!("note: {}", inspection.note);
        write_inspection(&mut folder, &inspection)?;
        folder.publish()?;
        stdout::print(match self.json {
            true => serde_json::to_string(&inspection.record).map_err(Failure::data)? + "\n",
            false => inspection.record.text() + &format!("\nresults in {}\n", self.out.display()),
        })
    }
}
