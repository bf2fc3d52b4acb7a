use serde::{Deserialize, Serialize};

/// The results of an inspection: `inspection.json`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct InspectionRecord {
    /// The CAD model's file.
    pub reference: String,
    /// Deviations up to this are accepted.
    pub tolerance_mm: f64,
    /// Radius of the patches over which deviations are averaged.
    pub patch_mm: f64,
    /// The part's pose: the rows of the 4 x 4 matrix that transforms points from the scan's world to the
    /// model; metres.
    pub reference_from_world: [[f64; 4]; 4],
    /// Share of the points, 0..=1, within a hundredth of the model's diagonal.
    pub fitted_share: f64,
    /// Number of compared points.
    pub n_points: usize,
    /// Share, 0..=1, of the model's surface with a measured point within a patch.
    pub inspected_share: f64,
    /// Share, 0..=1, of the points certainly within the tolerance.
    pub within_share: f64,
    /// Share, 0..=1, of the points for which noise hides the answer.
    pub uncertain_share: f64,
    /// Root mean square of all deviations.
    pub deviation_rms_mm: f64,
    /// 95th percentile of the absolute deviations.
    pub deviation_p95_mm: f64,
    /// Error that neighbouring points share, such as the waves of a stereo camera: the spread of most
    /// deviations that the noise within patches does not explain.
    pub correlated_error_mm: f64,
    /// Median standard error of the points' deviations; `None` if most patches hold too few points.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub standard_error_median_mm: Option<f64>,
    /// Share of each surface measured as demanded; empty if the results hold no frames.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub surfaces: Vec<SurfaceRecord>,
    /// Places where the part deviates, by descending deviation.
    pub defects: Vec<DefectRecord>,
}

/// A place where the part deviates from the model.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DefectRecord {
    /// Middle of the defect, in the coordinates of the model.
    pub center_m: [f64; 3],
    /// Size of the box around the defect.
    pub size_m: [f64; 3],
    /// Deviation of the defect, positive for excess material: nine tenths of its points deviate less.
    pub deviation_mm: f64,
    /// The standard error of the deviation.
    pub standard_error_mm: f64,
    /// Number of points.
    pub n_points: usize,
}

/// A surface of the part, and its share measured as demanded.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SurfaceRecord {
    /// Name of the surface.
    pub name: String,
    /// Maximum angle between the line of sight and the surface normal.
    pub angle_deg: f64,
    /// Minimum number of pixels per square millimetre in one picture.
    pub points_per_mm2: f64,
    /// Share, 0..=1, of the surface that a frame measured as demanded.
    pub measured_share: f64,
}
