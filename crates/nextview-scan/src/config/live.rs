use glam::DVec3;
use nextview::geometry::{Aabb, Pose};
use nextview::sensor::DepthRange;
use serde::{Deserialize, Serialize};

/// Settings of a scan with a user's camera, in addition to those of every scan.
///
/// A pose takes points from camera to world; the camera looks along z, and y points down.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields)]
pub struct LiveConfig {
    /// The object's box, given by its lowest and highest corners. By default, the box grows.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub box_m: Option<[f64; 6]>,
    /// Height of the table below the object. By default, there is no table, or it is found.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub table_z_m: Option<f64>,
    /// Minimum measured depth, at least 0. Default 0.
    pub min_depth_m: f64,
    /// Maximum measured depth; pixels without return are free up to it. Default 10.
    pub max_depth_m: f64,
    /// Pose of the first view if the box grows and a rule generates the candidates. It must show part of the
    /// object, and is no candidate.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub first_pose: Option<Pose>,
    /// The candidates. By default, the rule of `view_space` generates them around the object.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub poses: Vec<Pose>,
}

impl Default for LiveConfig {
    fn default() -> Self {
        Self {
            box_m: None,
            table_z_m: None,
            min_depth_m: 0.0,
            max_depth_m: 10.0,
            first_pose: None,
            poses: Vec::new(),
        }
    }
}

impl LiveConfig {
    /// The box, if known.
    pub fn bounds(&self) -> Option<Aabb> {
        self.box_m
            .map(|[x0, y0, z0, x1, y1, z1]| Aabb { min: DVec3::new(x0, y0, z0), max: DVec3::new(x1, y1, z1) })
    }

    /// The range of depths that the camera measures.
    pub fn depth_range(&self) -> DepthRange {
        DepthRange { min: self.min_depth_m, max: self.max_depth_m }
    }
}
