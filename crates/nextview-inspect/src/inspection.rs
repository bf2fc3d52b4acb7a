use crate::defects::defects;
use crate::deviation::{Deviation, Deviations, PointVerdict, deviations};
use crate::patches::{Patches, suitable_radius};
use crate::record::InspectionRecord;
use crate::seen::seen_as_demanded;
use glam::DVec3;
use nextview::Cancel;
use nextview::registration::SurfacePoint;
use nextview_scan::{
    Fault, Faults, ReferenceConfig, SavedModel, ScanConfig, ScanRecord, UnitName, rows_of_pose,
};
use nextview_sim::inspection::{KnownPart, PartFit};
use nextview_sim::mesh::sample_surface;
use rayon::prelude::*;
use std::path::{Path, PathBuf};

/// The settings of an inspection.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InspectionConfig {
    /// Deviations up to this are accepted, millimetres; positive. Default 0.5.
    pub tolerance_mm: f64,
    /// Radius of the patches over which deviations are averaged, millimetres; positive. A smaller radius
    /// shows smaller defects, a larger one is less noisy. Default 2, or more if the cloud's points are so
    /// sparse that more than a tenth of the patches would hold fewer than five of them.
    pub patch_mm: Option<f64>,
}

impl Default for InspectionConfig {
    fn default() -> Self {
        Self { tolerance_mm: 0.5, patch_mm: None }
    }
}

/// A part compared with its CAD model.
pub struct Inspection {
    /// The findings.
    pub record: InspectionRecord,
    /// The unit conversion of the CAD model's file.
    pub note: String,
    /// The points of the cloud, transformed to the coordinates of the model.
    pub(crate) points: Vec<SurfacePoint>,
    /// The deviation of each point.
    pub(crate) deviations: Vec<Deviation>,
}

/// Number of model samples used to measure its coverage.
const N_SAMPLES: usize = 20_000;

/// Returns the CAD model to compare a scan's results with: that of the scan, or another file, in another
/// unit. Fails if neither names one.
pub fn reference_of(
    results: &Path,
    mesh: Option<PathBuf>,
    unit: Option<UnitName>,
) -> Result<ReferenceConfig, Faults> {
    // First the check that reports missing results.
    ScanRecord::read(results)?;
    let mut of_scan = ScanConfig::load(&results.join("config.toml"), None)?;
    mesh.into_iter().for_each(|mesh| of_scan.set_reference(mesh));
    let missing = || Fault::request("the scan has no CAD model, and none is given");
    let reference = of_scan.reference.ok_or_else(|| missing().with_remedy("set `reference.mesh`"))?;
    Ok(ReferenceConfig { unit: unit.unwrap_or(reference.unit), ..reference })
}

/// Compares the cloud of a scan's results with a CAD model. The part's pose need not be known.
///
/// # Errors
/// If the folder holds no results, if the cloud has no normals, if the model does not fit it, or if it is
/// cancelled.
pub fn inspect(
    results: &Path,
    reference: &ReferenceConfig,
    config: InspectionConfig,
    cancel: &Cancel,
) -> Result<Inspection, Faults> {
    let values = [("tolerance_mm", Some(config.tolerance_mm)), ("patch_mm", config.patch_mm)];
    let faults = values
        .into_iter()
        .filter_map(|(key, value)| Some((key, value?)))
        .filter(|(_, value)| !(*value > 0.0 && value.is_finite()))
        .map(|(key, value)| Fault::of_value(key, value, "a positive number of millimetres"));
    if let Some(faults) = Faults::of(faults.collect()) {
        return Err(faults);
    }
    let (mesh, scaling) = reference.load()?;
    let name = reference.mesh.display().to_string();
    let table = ScanRecord::read(results)?.table();
    let cloud = SavedModel::read(&results.join("cloud.ply"))?.above(table);
    let with_normal = |p: &nextview::surface::CloudPoint| {
        Some((SurfacePoint { position: p.position, normal: p.normal? }, p.error.map(f64::from)))
    };
    let (in_world, expected): (Vec<SurfacePoint>, Vec<Option<f64>>) =
        cloud.points.iter().filter_map(with_normal).unzip();
    if in_world.is_empty() {
        return Err(Fault::data("cloud.ply holds no point of the object with a normal")
            .in_file(results)
            .into());
    }
    let part = KnownPart::new(&mesh)?;
    let PartFit { reference_from_world, share, .. } = part.fit(&in_world, |_| false, cancel)?;
    if share < PartFit::LEAST_SHARE {
        let message = format!(
            "{name} does not fit the cloud: in the best pose found, {:.0} % of the points lie near it, expected at least {:.0} %",
            1e2 * share,
            1e2 * PartFit::LEAST_SHARE
        );
        let remedy =
            "is it the model of this part, in the right `unit`, and does the cloud show nothing else?";
        return Err(Fault::data(message).with_remedy(remedy).into());
    }
    let moved = |point: &SurfacePoint| SurfacePoint {
        position: reference_from_world.transform_point(point.position),
        normal: reference_from_world.rotation() * point.normal,
    };
    let points: Vec<SurfacePoint> = in_world.iter().map(moved).collect();
    let positions: Vec<DVec3> = points.iter().map(|point| point.position).collect();
    let radius = config.patch_mm.map_or_else(|| suitable_radius(&positions), |patch_mm| patch_mm / 1e3);
    let patches = Patches::new(&positions, radius);
    let Deviations { of_points: deviations, correlated_error } =
        deviations(&points, &expected, &positions, part.surface(), &patches);
    let tolerance = config.tolerance_mm / 1e3;
    let share_of = |verdict: PointVerdict| {
        let n = deviations.iter().filter(|deviation| deviation.verdict(tolerance) == verdict).count();
        n as f64 / deviations.len() as f64
    };
    let samples = sample_surface(&mesh, N_SAMPLES, 0);
    let n_inspected = samples.par_iter().filter(|sample| patches.around(**sample).next().is_some()).count();
    let square = deviations.iter().map(|deviation| deviation.mean.powi(2)).sum::<f64>();
    let median_error = 1e3 * quantile(deviations.iter().map(|deviation| deviation.error), 0.5);
    let record = InspectionRecord {
        reference: name,
        tolerance_mm: config.tolerance_mm,
        patch_mm: 1e3 * radius,
        reference_from_world: rows_of_pose(&reference_from_world),
        fitted_share: share,
        n_points: points.len(),
        inspected_share: n_inspected as f64 / samples.len() as f64,
        within_share: share_of(PointVerdict::Within),
        uncertain_share: share_of(PointVerdict::Uncertain),
        deviation_rms_mm: 1e3 * (square / deviations.len() as f64).sqrt(),
        deviation_p95_mm: 1e3 * quantile(deviations.iter().map(|deviation| deviation.mean.abs()), 0.95),
        correlated_error_mm: 1e3 * correlated_error,
        standard_error_median_mm: Some(median_error).filter(|error| error.is_finite()),
        surfaces: seen_as_demanded(results, reference, &mesh, &reference_from_world.inverse(), cancel)?,
        defects: defects(&positions, &deviations, tolerance, &patches),
    };
    Ok(Inspection { record, note: format!("{}: {scaling}", reference.mesh.display()), points, deviations })
}

fn quantile(values: impl Iterator<Item = f64>, share: f64) -> f64 {
    let mut sorted: Vec<f64> = values.collect();
    sorted.sort_by(f64::total_cmp);
    sorted[(share * (sorted.len() - 1) as f64).round() as usize]
}
