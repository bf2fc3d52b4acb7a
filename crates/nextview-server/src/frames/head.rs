use crate::refusal::Refusal;
use nextview::geometry::Pose;
use nextview::sensor::Intrinsics;
use nextview_scan::{Fault, pose_of_rows};
use schemars::JsonSchema;
use serde::Deserialize;

/// A frame without its images.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct FrameHead {
    /// A name unique among the frames of the scan, 1 to 128 characters: a frame sent again under it counts
    /// once. Required except to locate an image.
    #[serde(default)]
    pub id: Option<String>,
    /// Pose of the camera: the rows of the 4 x 4 matrix that takes points from camera to world in metres. The
    /// camera looks along z, with y downwards. `None` to locate the frame, which requires
    /// `registration.given_poses` = tracked.
    #[serde(default)]
    pub world_from_camera: Option<[[f64; 4]; 4]>,
    /// Metres per unit of 16-bit depth. Default 0.001.
    #[serde(default = "millimetre")]
    pub depth_scale_m: f64,
    /// The optics; if stated, they must equal those of the scan.
    #[serde(default)]
    #[schemars(with = "Option<std::collections::BTreeMap<String, serde_json::Value>>")]
    pub camera: Option<Intrinsics>,
}

pub(super) fn millimetre() -> f64 {
    1e-3
}

impl FrameHead {
    /// The id, required to observe a frame.
    pub fn id(&self) -> Result<&str, Refusal> {
        let expected = "1 to 128 characters, none of them a control character";
        let id = self.id.as_deref().ok_or_else(|| {
            Refusal::content(Fault::of_value("id", "missing", format!("a name of the frame: {expected}")))
        })?;
        let is_short = (1..=128).contains(&id.chars().count());
        if !is_short || id.chars().any(char::is_control) {
            let id: String = id.chars().take(128).collect();
            return Err(Refusal::content(Fault::of_value("id", id.escape_debug(), expected)));
        }
        Ok(id)
    }

    /// The pose, if there is one. Fails if anything in the head is invalid or does not match this camera.
    pub fn pose(&self, camera: &Intrinsics) -> Result<Option<Pose>, Refusal> {
        let scale = self.depth_scale_m;
        if !(scale > 0.0 && scale <= 1.0) {
            let expected = "a positive number of metres, at most 1";
            return Err(Refusal::content(Fault::of_value("depth_scale_m", scale, expected)));
        }
        if let Some(given) = self.camera.filter(|given| given != camera) {
            let text = |camera: &Intrinsics| serde_json::to_string(camera).unwrap_or_default();
            let fault =
                Fault::of_value("camera", text(&given), format!("that of the scan, {}", text(camera)));
            return Err(Refusal::content(
                fault.with_remedy("leave it out, or create a scan for this camera"),
            ));
        }
        let rows = self.world_from_camera.as_ref();
        rows.map(|rows| pose_of_rows("world_from_camera", rows)).transpose().map_err(Refusal::content)
    }
}
