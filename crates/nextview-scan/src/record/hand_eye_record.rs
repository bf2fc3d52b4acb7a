use glam::{DQuat, DVec3};
use nextview::geometry::Pose;
use nextview::registration::HandEyeError;
use serde::{Deserialize, Serialize};

/// The error that all given poses share, as found from the frames. For a camera on a robot, this is the error
/// of the hand-eye calibration.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct HandEyeRecord {
    /// The pose by which given poses are to be multiplied from the right: the translation. The true
    /// `flange_from_camera` is the calibrated one times this pose.
    pub translation_m: [f64; 3],
    /// Its rotation, scalar last.
    pub quaternion_xyzw: [f64; 4],
    /// Length of the translation.
    pub moved_mm: f64,
    /// Angle of the rotation.
    pub turned_deg: f64,
    /// Standard deviation of the translation: of its distance from the true one.
    pub deviation_mm: f64,
    /// Standard deviation of the rotation.
    pub deviation_deg: f64,
}

impl HandEyeRecord {
    /// Whether the frames show that there is an error; see [`HandEyeError::is_shown`].
    pub fn is_shown(&self) -> bool {
        self.found().is_some_and(|error| error.is_shown())
    }

    fn found(&self) -> Option<HandEyeError> {
        let rotation = DQuat::from_array(self.quaternion_xyzw);
        Some(HandEyeError {
            given_from_camera: Pose::new(rotation, DVec3::from_array(self.translation_m)).ok()?,
            position_deviation: 1e-3 * self.deviation_mm,
            rotation_deviation: self.deviation_deg.to_radians(),
        })
    }
}

impl From<HandEyeError> for HandEyeRecord {
    fn from(error: HandEyeError) -> Self {
        Self {
            translation_m: error.given_from_camera.translation().to_array(),
            quaternion_xyzw: error.given_from_camera.rotation().to_array(),
            moved_mm: 1e3 * error.moved(),
            turned_deg: error.turned().to_degrees(),
            deviation_mm: 1e3 * error.position_deviation,
            deviation_deg: error.rotation_deviation.to_degrees(),
        }
    }
}
