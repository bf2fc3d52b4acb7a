use crate::deviation::{Deviation, PointVerdict};
use crate::inspection::Inspection;
use nextview_scan::Fault;
use nextview_scan::files::ResultFolder;
use std::io::Write;

/// The files of an inspection.
pub const INSPECTION_FILES: &[&str] = &["inspection.json", "deviation.ply"];

/// Adds the files to a folder: the record, and the points in the coordinates of the model with their
/// deviations. Colours are red outside the model and blue inside, strongest at twice the tolerance, and grey
/// where noise hides the answer.
pub fn write_inspection(folder: &mut ResultFolder, inspection: &Inspection) -> Result<(), Fault> {
    folder.add("inspection.json", |w| {
        serde_json::to_writer_pretty(&mut *w, &inspection.record).map_err(Fault::data)?;
        Ok(w.write_all(b"\n")?)
    })?;
    folder.add("deviation.ply", |w| Ok(write_points(w, inspection)?))
}

fn write_points(w: &mut Vec<u8>, inspection: &Inspection) -> std::io::Result<()> {
    writeln!(w, "ply\nformat binary_little_endian 1.0\nelement vertex {}", inspection.points.len())?;
    for column in ["x", "y", "z", "nx", "ny", "nz", "deviation_mm", "standard_error_mm"] {
        writeln!(w, "property float {column}")?;
    }
    writeln!(w, "property uchar red\nproperty uchar green\nproperty uchar blue\nend_header")?;
    for (point, deviation) in inspection.points.iter().zip(&inspection.deviations) {
        let numbers = [point.position.to_array(), point.normal.to_array()].concat();
        let numbers = numbers.into_iter().chain([1e3 * deviation.mean, 1e3 * deviation.error]);
        numbers.for_each(|number| w.extend((number as f32).to_le_bytes()));
        w.extend(color(*deviation, inspection.record.tolerance_mm / 1e3));
    }
    Ok(())
}

fn color(deviation: Deviation, tolerance: f64) -> [u8; 3] {
    if deviation.verdict(tolerance) == PointVerdict::Uncertain {
        return [160; 3];
    }
    let strength = (deviation.mean / (2.0 * tolerance)).clamp(-1.0, 1.0);
    let pale = (255.0 * (1.0 - strength.abs())).round() as u8;
    if strength > 0.0 { [255, pale, pale] } else { [pale, pale, 255] }
}
