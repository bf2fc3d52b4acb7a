use glam::DVec3;
use nextview::geometry::{Aabb, Pose};
use nextview::sensor::DepthRange;
use serde::{Deserialize, Serialize};

/// What decides a scan with a user's camera, besides what decides every scan.
///
/// A pose takes points of the camera to the world; the camera looks along z, and y points down.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields)]
pub struct LiveConfig {
    /// The box that the object lies in, by its lowest and its highest corner; without it, the box grows.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub box_m: Option<[f64; 6]>,
    /// Height of the table that the object stands on; without it, there is no table, or it is found.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub table_z_m: Option<f64>,
    /// Surfaces nearer than this are not measured, at least 0. Default 0.
    pub min_depth_m: f64,
    /// Surfaces farther away than this are not measured; up to it, pixels without return are free. Default
    /// 10.
    pub max_depth_m: f64,
    /// The pose of the first view, where the box grows and a rule makes the candidates: it must show some of
    /// the object. It is no candidate.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub first_pose: Option<Pose>,
    /// The candidates; without them, the rule of `view_space` makes them, around the object.
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
    /// The box, if it is known.
    pub fn bounds(&self) -> Option<Aabb> {
        self.box_m
            .map(|[x0, y0, z0, x1, y1, z1]| Aabb { min: DVec3::new(x0, y0, z0), max: DVec3::new(x1, y1, z1) })
    }

    /// The depths that the camera measures.
    pub fn depth_range(&self) -> DepthRange {
        DepthRange { min: self.min_depth_m, max: self.max_depth_m }
    }
}
