use super::ScanRecord;
use nextview::geometry::Pose;

/// Quality of a cloud or a mesh against the true surface. Records of older versions lack the optional fields.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct QualityMm {
    /// Mean distance from the points of the model to the true surface.
    pub accuracy_mean_mm: f64,
    /// Median of these distances.
    pub accuracy_median_mm: f64,
    /// 95th percentile of these distances.
    pub accuracy_p95_mm: f64,
    /// Share, 0..=1, of the points of the model within 1 mm of the true surface.
    pub precision_1mm: Option<f64>,
    /// As `precision_1mm`, but within 2 mm.
    pub precision_2mm: Option<f64>,
    /// As `precision_1mm`, but within 5 mm.
    pub precision_5mm: Option<f64>,
    /// Share, 0..=1, of the whole true surface with a point of the model within 1 mm.
    pub completeness_1mm: f64,
    /// As `completeness_1mm`, but within 2 mm.
    pub completeness_2mm: f64,
    /// As `completeness_1mm`, but within 5 mm.
    pub completeness_5mm: f64,
    /// Mean distance from the true surface to the model.
    pub completeness_mean_mm: f64,
    /// Share, 0..=1, of the reachable surface with a point of the model within 1 mm.
    pub recall_1mm: Option<f64>,
    /// As `recall_1mm`, but within 2 mm.
    pub recall_2mm: Option<f64>,
    /// As `recall_1mm`, but within 5 mm.
    pub recall_5mm: Option<f64>,
    /// Mean distance from the reachable surface to the model.
    pub reachable_completeness_mean_mm: Option<f64>,
    /// Harmonic mean of precision and recall at 1 mm, 0..=1.
    pub f_score_1mm: Option<f64>,
    /// As `f_score_1mm`, but at 2 mm.
    pub f_score_2mm: Option<f64>,
    /// As `f_score_1mm`, but at 5 mm.
    pub f_score_5mm: Option<f64>,
    /// Chamfer distance: mean of `accuracy_mean_mm` and `reachable_completeness_mean_mm`.
    pub chamfer_mm: Option<f64>,
}

impl ScanRecord {
    /// Quality of the final cloud; `None` if it was not measured.
    pub fn cloud(&self) -> Option<QualityMm> {
        Some(QualityMm {
            accuracy_mean_mm: self.cloud_accuracy_mean_mm?,
            accuracy_median_mm: self.cloud_accuracy_median_mm?,
            accuracy_p95_mm: self.cloud_accuracy_p95_mm?,
            precision_1mm: self.cloud_precision_1mm,
            precision_2mm: self.cloud_precision_2mm,
            precision_5mm: self.cloud_precision_5mm,
            completeness_1mm: self.cloud_completeness_1mm?,
            completeness_2mm: self.cloud_completeness_2mm?,
            completeness_5mm: self.cloud_completeness_5mm?,
            completeness_mean_mm: self.cloud_completeness_mean_mm?,
            recall_1mm: self.cloud_recall_1mm,
            recall_2mm: self.cloud_recall_2mm,
            recall_5mm: self.cloud_recall_5mm,
            reachable_completeness_mean_mm: self.cloud_reachable_completeness_mean_mm,
            f_score_1mm: self.cloud_f_score_1mm,
            f_score_2mm: self.cloud_f_score_2mm,
            f_score_5mm: self.cloud_f_score_5mm,
            chamfer_mm: self.cloud_chamfer_mm,
        })
    }

    /// Quality of the final mesh; `None` if it was not measured.
    pub fn mesh(&self) -> Option<QualityMm> {
        Some(QualityMm {
            accuracy_mean_mm: self.mesh_accuracy_mean_mm?,
            accuracy_median_mm: self.mesh_accuracy_median_mm?,
            accuracy_p95_mm: self.mesh_accuracy_p95_mm?,
            precision_1mm: self.mesh_precision_1mm,
            precision_2mm: self.mesh_precision_2mm,
            precision_5mm: self.mesh_precision_5mm,
            completeness_1mm: self.mesh_completeness_1mm?,
            completeness_2mm: self.mesh_completeness_2mm?,
            completeness_5mm: self.mesh_completeness_5mm?,
            completeness_mean_mm: self.mesh_completeness_mean_mm?,
            recall_1mm: self.mesh_recall_1mm,
            recall_2mm: self.mesh_recall_2mm,
            recall_5mm: self.mesh_recall_5mm,
            reachable_completeness_mean_mm: self.mesh_reachable_completeness_mean_mm,
            f_score_1mm: self.mesh_f_score_1mm,
            f_score_2mm: self.mesh_f_score_2mm,
            f_score_5mm: self.mesh_f_score_5mm,
            chamfer_mm: self.mesh_chamfer_mm,
        })
    }

    /// Sets the quality of the final cloud.
    pub fn set_cloud(&mut self, quality: Option<QualityMm>) {
        self.cloud_accuracy_mean_mm = quality.map(|q| q.accuracy_mean_mm);
        self.cloud_accuracy_median_mm = quality.map(|q| q.accuracy_median_mm);
        self.cloud_accuracy_p95_mm = quality.map(|q| q.accuracy_p95_mm);
        self.cloud_precision_1mm = quality.and_then(|q| q.precision_1mm);
        self.cloud_precision_2mm = quality.and_then(|q| q.precision_2mm);
        self.cloud_precision_5mm = quality.and_then(|q| q.precision_5mm);
        self.cloud_completeness_1mm = quality.map(|q| q.completeness_1mm);
        self.cloud_completeness_2mm = quality.map(|q| q.completeness_2mm);
        self.cloud_completeness_5mm = quality.map(|q| q.completeness_5mm);
        self.cloud_completeness_mean_mm = quality.map(|q| q.completeness_mean_mm);
        self.cloud_recall_1mm = quality.and_then(|q| q.recall_1mm);
        self.cloud_recall_2mm = quality.and_then(|q| q.recall_2mm);
        self.cloud_recall_5mm = quality.and_then(|q| q.recall_5mm);
        self.cloud_reachable_completeness_mean_mm = quality.and_then(|q| q.reachable_completeness_mean_mm);
        self.cloud_f_score_1mm = quality.and_then(|q| q.f_score_1mm);
        self.cloud_f_score_2mm = quality.and_then(|q| q.f_score_2mm);
        self.cloud_f_score_5mm = quality.and_then(|q| q.f_score_5mm);
        self.cloud_chamfer_mm = quality.and_then(|q| q.chamfer_mm);
    }

    /// Sets the quality of the final mesh.
    pub fn set_mesh(&mut self, quality: Option<QualityMm>) {
        self.mesh_accuracy_mean_mm = quality.map(|q| q.accuracy_mean_mm);
        self.mesh_accuracy_median_mm = quality.map(|q| q.accuracy_median_mm);
        self.mesh_accuracy_p95_mm = quality.map(|q| q.accuracy_p95_mm);
        self.mesh_precision_1mm = quality.and_then(|q| q.precision_1mm);
        self.mesh_precision_2mm = quality.and_then(|q| q.precision_2mm);
        self.mesh_precision_5mm = quality.and_then(|q| q.precision_5mm);
        self.mesh_completeness_1mm = quality.map(|q| q.completeness_1mm);
        self.mesh_completeness_2mm = quality.map(|q| q.completeness_2mm);
        self.mesh_completeness_5mm = quality.map(|q| q.completeness_5mm);
        self.mesh_completeness_mean_mm = quality.map(|q| q.completeness_mean_mm);
        self.mesh_recall_1mm = quality.and_then(|q| q.recall_1mm);
        self.mesh_recall_2mm = quality.and_then(|q| q.recall_2mm);
        self.mesh_recall_5mm = quality.and_then(|q| q.recall_5mm);
        self.mesh_reachable_completeness_mean_mm = quality.and_then(|q| q.reachable_completeness_mean_mm);
        self.mesh_f_score_1mm = quality.and_then(|q| q.f_score_1mm);
        self.mesh_f_score_2mm = quality.and_then(|q| q.f_score_2mm);
        self.mesh_f_score_5mm = quality.and_then(|q| q.f_score_5mm);
        self.mesh_chamfer_mm = quality.and_then(|q| q.chamfer_mm);
    }

    /// Sets the rigid motion of the model before measuring, for an object with this middle in metres.
    pub fn set_alignment(&mut self, truth_from_model: &Pose, middle: glam::DVec3) {
        let (rotation, moved) = (truth_from_model.rotation(), truth_from_model.transform_point(middle));
        let turned = 2.0 * rotation.xyz().length().atan2(rotation.w.abs());
        self.alignment_translation_m = Some(truth_from_model.translation().to_array());
        self.alignment_quaternion_xyzw = Some(rotation.to_array());
        self.alignment_moved_mm = Some(1e3 * moved.distance(middle));
        self.alignment_turned_deg = Some(turned.to_degrees());
    }
}
