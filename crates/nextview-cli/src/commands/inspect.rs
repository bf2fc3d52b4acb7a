use super::values::{named, positive};
use crate::{Failure, stdout};
use clap::Args;
use nextview::Cancel;
use nextview_inspect::{INSPECTION_FILES, InspectionConfig, InspectionRecord, inspect, write_inspection};
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
            false => text(&inspection.record) + &format!("\nresults in {}\n", self.out.display()),
        })
    }
}

fn text(record: &InspectionRecord) -> String {
    let percent = |share: f64| format!("{:.1} %", 1e2 * share);
    let standard_error = match record.standard_error_median_mm {
        Some(error) => format!(
            "{error:.3} mm (median), {:.3} mm of it common to neighbouring points",
            record.correlated_error_mm
        ),
        None => "not known: most patches hold too few points; try a larger --patch-mm".to_owned(),
    };
    let mut text = format!(
        "points                 {}\n\
         near the model         {}\n\
         surface inspected      {}\n\
         within {} mm{:width$}{}\n\
         uncertain              {}\n\
         deviation              {:.3} mm (root mean square), {:.3} mm (95 %)\n\
         standard error         {}\n\
         patches                {:.1} mm around each point\n",
        record.n_points,
        percent(record.fitted_share),
        percent(record.inspected_share),
        record.tolerance_mm,
        "",
        percent(record.within_share),
        percent(record.uncertain_share),
        record.deviation_rms_mm,
        record.deviation_p95_mm,
        standard_error,
        record.patch_mm,
        width = 13_usize.saturating_sub(record.tolerance_mm.to_string().len()),
    );
    if record.defects.is_empty() {
        return text + "\nno defect found\n";
    }
    text += "\ndefect  deviation           where (x y z)            size            points\n";
    for (i, defect) in record.defects.iter().enumerate() {
        let mm = |values: [f64; 3]| values.map(|value| format!("{:.1}", 1e3 * value)).join(" ");
        text += &format!(
            "{:6}  {:+.2} ± {:.2} mm     {:>22} mm  {:>14} mm  {:6}\n",
            i + 1,
            defect.deviation_mm,
            defect.standard_error_mm,
            mm(defect.center_m),
            mm(defect.size_m),
            defect.n_points
        );
    }
    text
}
