use super::RegistrationMode;
use crate::Error;
use crate::checked::{check_range, checked_when_read};
use crate::degrees;
use crate::geometry::Lattice;
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// Configuration of the alignment of frames, and of the conditions that refuse one.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields, remote = "Self")]
pub struct RegistrationConfig {
    /// Whether a session aligns frames: `true`, `false`, or `"auto"`, which begins once the frames show that
    /// the given poses are wrong. Default: `"auto"` for frames of a camera or a recording, `false` for
    /// others.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub enabled: Option<RegistrationMode>,
    /// Edge of the cells in which points are pooled, metres, at least 0.0001. Default: the session's voxel
    /// size, but at most 0.005, which gives some thousand points per object, each the mean of several pixels.
    #[serde(rename = "spacing_m", skip_serializing_if = "Option::is_none")]
    pub spacing: Option<f64>,
    /// Maximum error of a given position, metres, positive; an alignment that moves the camera farther is
    /// refused. The search for correspondences starts at this distance. Default 0.05.
    #[serde(rename = "position_uncertainty_m")]
    pub position_uncertainty: f64,
    /// Maximum error of a given rotation, radians, above 0 up to pi; degrees in files. Default 10 degrees.
    #[serde(rename = "rotation_uncertainty_deg", with = "degrees")]
    #[cfg_attr(feature = "schema", schemars(with = "f64"))]
    pub rotation_uncertainty: f64,
    /// Minimum share, 0..=1, of the frame's points that must lie on the known surface after the alignment.
    /// Default 0.15.
    pub min_overlap: f64,
    /// Minimum [stiffness](super::Registration::stiffness), 0..=1; the given pose stays in directions with
    /// less. Default 0.005: with less, frames were often turned by degrees about the axis of a bottle or a
    /// handle.
    pub min_stiffness: f64,
    /// Prior knowledge of the given poses, which determines how the scan is tied to the world. Default:
    /// independent.
    pub given_poses: GivenPoses,
}

/// Prior knowledge of the given poses.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum GivenPoses {
    /// Each has its own error, and all share another: the frames lie where this is most likely.
    #[default]
    Independent,
    /// The first pose is exact: its frame defines the world.
    FirstIsRight,
    /// The poses come from alignment to the surface known before. They prove nothing about each other, and
    /// the first frame defines the world.
    Tracked,
}

checked_when_read!(RegistrationConfig);

impl Default for RegistrationConfig {
    fn default() -> Self {
        Self {
            enabled: None,
            spacing: None,
            position_uncertainty: 0.05,
            rotation_uncertainty: 10_f64.to_radians(),
            min_overlap: 0.15,
            min_stiffness: 0.005,
            given_poses: GivenPoses::Independent,
        }
    }
}

impl RegistrationConfig {
    /// Default edge of the cells in which points are pooled, metres.
    pub const DEFAULT_SPACING: f64 = 0.005;

    /// Returns the defaults, with all frames aligned.
    pub fn enabled() -> Self {
        Self { enabled: Some(RegistrationMode::On), ..Self::default() }
    }

    /// Returns the mode; [`Off`](RegistrationMode::Off) if none is set.
    pub fn mode(&self) -> RegistrationMode {
        self.enabled.unwrap_or(RegistrationMode::Off)
    }

    /// Fails on the first value out of range, whether enabled or not.
    pub fn check(&self) -> Result<(), Error> {
        let positive = f64::MIN_POSITIVE..=f64::MAX;
        if let Some(spacing) = self.spacing {
            check_range("spacing_m", spacing, Lattice::MIN_VOXEL_SIZE..=f64::MAX, "at least 0.0001")?;
        }
        check_range("position_uncertainty_m", self.position_uncertainty, positive, "a positive number")?;
        if !(self.rotation_uncertainty > 0.0 && self.rotation_uncertainty <= PI) {
            let value = degrees::tidy(self.rotation_uncertainty);
            return Err(Error::invalid("rotation_uncertainty_deg", value, "above 0 and up to 180"));
        }
        check_range("min_overlap", self.min_overlap, 0.0..=1.0, "0 to 1")?;
        check_range("min_stiffness", self.min_stiffness, 0.0..=1.0, "0 to 1")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn refuses_what_is_out_of_range() {
        let good = RegistrationConfig::default();
        assert!(good.check().is_ok());
        for (bad, name) in [
            (RegistrationConfig { spacing: Some(0.0), ..good }, "spacing_m is 0"),
            (RegistrationConfig { spacing: Some(f64::NAN), ..good }, "spacing_m is NaN"),
            (RegistrationConfig { position_uncertainty: 0.0, ..good }, "position_uncertainty_m is 0"),
            (
                RegistrationConfig { position_uncertainty: f64::INFINITY, ..good },
                "position_uncertainty_m is inf",
            ),
            (RegistrationConfig { rotation_uncertainty: 3.2, ..good }, "rotation_uncertainty_deg is 183.3"),
            (RegistrationConfig { min_overlap: 1.1, ..good }, "min_overlap is 1.1"),
            (RegistrationConfig { min_stiffness: -0.1, ..good }, "min_stiffness is -0.1"),
        ] {
            assert!(bad.check().unwrap_err().to_string().starts_with(name));
        }
    }
}
