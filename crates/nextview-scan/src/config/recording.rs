use glam::DVec3;
use nextview::geometry::Aabb;
use nextview_recording::ReadOptions;
use serde::{Deserialize, Serialize};

/// What decides a scan of recorded frames, besides what decides every scan.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields)]
pub struct RecordingConfig {
    /// The box that the object lies in, by its lowest and its highest corner; without it, the box grows.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub box_m: Option<[f64; 6]>,
    /// Height of the table that the object stands on; without it, there is no table, or it is found.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub table_z_m: Option<f64>,
    /// A mesh of the true object, in the unit of the scan's `unit`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub truth: Option<String>,
    /// A file of the matrix that takes points of the recording to the mesh; without it, they are in the same
    /// place.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub truth_from_world: Option<String>,
    /// How the files are read.
    #[serde(deserialize_with = "ReadOptions::deserialize")]
    pub read: ReadOptions,
}

impl RecordingConfig {
    /// The box, if it is known.
    pub fn bounds(&self) -> Option<Aabb> {
        self.box_m
            .map(|[x0, y0, z0, x1, y1, z1]| Aabb { min: DVec3::new(x0, y0, z0), max: DVec3::new(x1, y1, z1) })
    }
}
