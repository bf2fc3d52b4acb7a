use crate::{QualityMm, ScanRecord};
use glam::DVec3;
use nextview::geometry::Pose;
use nextview_model::SurfaceMesh;
use nextview_sim::quality::{Quality, ReachableSurface, TrueSurface};

/// Fills in the quality of a model after a rigid motion, true world from model.
pub(in crate::source) fn measure_model(
    (surface, reachable): (&TrueSurface, Option<&ReachableSurface>),
    truth_from_model: &Pose,
    cloud: &[DVec3],
    mesh: Option<&SurfaceMesh>,
    record: &mut ScanRecord,
) {
    let moved = |points: &[DVec3]| -> Vec<DVec3> {
        points.iter().map(|point| truth_from_model.transform_point(*point)).collect()
    };
    record.set_alignment(truth_from_model, surface.distance().bounds().center());
    record.set_cloud(surface.of_points(&moved(cloud), reachable).map(quality_mm));
    if let Some(SurfaceMesh { vertices, triangles }) = mesh {
        let mesh = SurfaceMesh { vertices: moved(vertices), triangles: triangles.clone() };
        record.set_mesh(surface.of_mesh(&mesh, reachable).map(quality_mm));
    }
}

/// A quality in the units of records.
fn quality_mm(quality: Quality) -> QualityMm {
    let Quality { accuracy, precision, completeness, reachable } = quality;
    let at = |values: Option<[f64; 3]>, i: usize| values.map(|values| values[i]);
    let (recall, f_score) = (quality.recall(), quality.f_score());
    QualityMm {
        accuracy_mean_mm: 1e3 * accuracy.mean,
        accuracy_median_mm: 1e3 * accuracy.median,
        accuracy_p95_mm: 1e3 * accuracy.p95,
        precision_1mm: Some(precision[0]),
        precision_2mm: Some(precision[1]),
        precision_5mm: Some(precision[2]),
        completeness_1mm: completeness.within[0],
        completeness_2mm: completeness.within[1],
        completeness_5mm: completeness.within[2],
        completeness_mean_mm: 1e3 * completeness.mean,
        recall_1mm: at(recall, 0),
        recall_2mm: at(recall, 1),
        recall_5mm: at(recall, 2),
        reachable_completeness_mean_mm: reachable.map(|part| 1e3 * part.mean),
        f_score_1mm: at(f_score, 0),
        f_score_2mm: at(f_score, 1),
        f_score_5mm: at(f_score, 2),
        chamfer_mm: quality.chamfer().map(|distance| 1e3 * distance),
    }
}
