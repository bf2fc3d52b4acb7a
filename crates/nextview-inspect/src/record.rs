use serde::{Deserialize, Serialize};

/// What an inspection found: `inspection.json`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct InspectionRecord {
    /// The CAD model's file.
    pub reference: String,
    /// Deviations up to this are none.
    pub tolerance_mm: f64,
    /// Radius of the patches over which deviations are averaged.
    pub patch_mm: f64,
    /// Where the part was: the rows of the 4 x 4 matrix that takes points of the scan's world to the model;
    /// metres.
    pub reference_from_world: [[f64; 4]; 4],
    /// Share of the points, 0..=1, within a hundredth of the model's diagonal.
    pub fitted_share: f64,
    /// Number of points that were compared.
    pub n_points: usize,
    /// Share, 0..=1, of the model's surface within a patch of which something was measured.
    pub inspected_share: f64,
    /// Share, 0..=1, of the points that are within the tolerance for sure.
    pub within_share: f64,
    /// Share, 0..=1, of the points of which noise hides whether they are.
    pub uncertain_share: f64,
    /// Root of the mean square of all deviations.
    pub deviation_rms_mm: f64,
    /// 95 % of the points deviate less.
    pub deviation_p95_mm: f64,
    /// The part of the standard errors that neighbouring points have in common, as the waves of a stereo
    /// camera: what most deviations vary more than the noise within patches explains.
    pub correlated_error_mm: f64,
    /// Half of the points have a smaller standard error of their deviation; none where most patches hold too
    /// few points to tell.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub standard_error_median_mm: Option<f64>,
    /// How much of each surface was measured as it is to be seen; empty where the results hold no frames.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub surfaces: Vec<SurfaceRecord>,
    /// Where the part deviates, the largest deviation first.
    pub defects: Vec<DefectRecord>,
}

/// A place where the part deviates from the model.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DefectRecord {
    /// Its middle, in the coordinates of the model.
    pub center_m: [f64; 3],
    /// Size of the box around it.
    pub size_m: [f64; 3],
    /// By how much: positive where there is too much material. Nine tenths of its points deviate less.
    pub deviation_mm: f64,
    /// The standard error of that.
    pub standard_error_mm: f64,
    /// Number of its points.
    pub n_points: usize,
}

/// A surface of the part, and how much of it was measured as it is to be seen.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SurfaceRecord {
    /// Its name.
    pub name: String,
    /// Largest angle between the line of sight and its normal.
    pub angle_deg: f64,
    /// Least number of pixels of one picture on each square millimetre.
    pub points_per_mm2: f64,
    /// Share, 0..=1, of it that a frame measured like that.
    pub measured_share: f64,
}
