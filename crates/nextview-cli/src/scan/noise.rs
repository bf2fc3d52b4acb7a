use crate::Failure;
use clap::ValueEnum;
use nextview_sim::noise::{DepthNoise, Noise, PoseError};
use serde::{Deserialize, Serialize};

/// The errors of the simulated camera. Their seed is their own, so that planners with several seeds face the same errors.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub(crate) struct NoiseConfig {
    pub model: NoiseModel,
    pub seed: u64,
    /// Standard deviation along each axis of the position that a frame claims.
    pub pose_error_mm: f64,
    /// Standard deviation about each axis of the rotation that a frame claims.
    pub pose_error_deg: f64,
    /// Whether the first frame claims the right pose all the same, so that all errors are relative to it.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub first_pose_is_right: bool,
    /// Of the model, unless it is none.
    pub depth: DepthNoise,
}

/// What is wrong with the depth.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum NoiseModel {
    /// Nothing: every pixel measures, and exactly
    #[default]
    None,
    /// Errors and losses of the RealSense D435i, a stereo camera; [noise.depth] of a configuration changes them
    D435i,
}

impl NoiseConfig {
    /// What the simulated camera is told.
    pub fn noise(&self) -> Noise {
        Noise {
            seed: self.seed,
            first_pose_is_right: self.first_pose_is_right,
            depth: (self.model != NoiseModel::None).then_some(self.depth),
            pose: PoseError {
                translation_sigma: self.pose_error_mm / 1e3,
                rotation_sigma: self.pose_error_deg.to_radians(),
            },
        }
    }

    /// Whether frames claim wrong poses.
    pub fn is_pose_wrong(&self) -> bool {
        self.pose_error_mm > 0.0 || self.pose_error_deg > 0.0
    }

    /// Fails on the first parameter out of its range, of a model that is off as well.
    pub fn check(&self) -> Result<(), Failure> {
        let limit_deg = 1_f64.to_degrees().floor();
        let errors = [
            ("pose_error_mm", self.pose_error_mm, 1000.0),
            ("pose_error_deg", self.pose_error_deg, limit_deg),
        ];
        for (name, value, limit) in errors {
            if !(0.0..=limit).contains(&value) {
                return Err(Failure::usage(format!("{name} is {value}, expected 0 to {limit}")));
            }
        }
        Ok(self.depth.check()?)
    }
}
