use glam::DVec3;
use nextview::geometry::Aabb;
use nextview_recording::ReadOptions;
use serde::{Deserialize, Serialize};

/// Settings of a scan of recorded frames, in addition to those of every scan.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields)]
pub struct RecordingConfig {
    /// The object's box, given by its lowest and highest corners. By default, the box grows.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub box_m: Option<[f64; 6]>,
    /// Height of the table below the object. By default, there is no table, or it is found.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub table_z_m: Option<f64>,
    /// A mesh of the true object, in the scan's `unit`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub truth: Option<String>,
    /// File of the matrix that takes points from recording to mesh. Default: identity.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub truth_from_world: Option<String>,
    /// Options for reading the files.
    #[serde(deserialize_with = "ReadOptions::deserialize")]
    pub read: ReadOptions,
}

impl RecordingConfig {
    /// The box, if known.
    pub fn bounds(&self) -> Option<Aabb> {
        self.box_m
            .map(|[x0, y0, z0, x1, y1, z1]| Aabb { min: DVec3::new(x0, y0, z0), max: DVec3::new(x1, y1, z1) })
    }
}
