use super::millimetres::of_least_depth;
use super::names::named;
use crate::Fault;
use nextview::sensor::DepthRange;
use nextview_sim::noise::{Noise, PoseError, SensorNoise};
use serde::{Deserialize, Serialize};

/// Errors of the simulated camera. They have their own seed: planners with several seeds face the same
/// errors.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields)]
pub struct NoiseConfig {
    /// Model of the depth errors.
    pub model: NoiseModel,
    /// Seed of all draws.
    pub seed: u64,
    /// Standard deviation, along each axis, of the position that a frame claims, 0..=1000.
    pub pose_error_mm: f64,
    /// Standard deviation, about each axis, of the rotation that a frame claims.
    pub pose_error_deg: f64,
    /// Whether the first frame claims the true pose, which makes all errors relative to it.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub first_pose_is_right: bool,
    /// Parameters of the model, unless it is none. Defaults are those of the named sensor, if any.
    #[serde(deserialize_with = "SensorNoise::deserialize")]
    pub depth: SensorNoise,
}

named! {
    /// Errors and losses of the depth.
    #[derive(Default)]
    pub enum NoiseModel {
        #[default] None = "none": "No noise: every pixel measures, and exactly",
        D435i = "d435i": "Errors and losses of the RealSense D435i, a stereo camera; [noise.depth] of a configuration changes them",
        Sensor = "sensor": "Errors and losses of the sensor, which is the default if a sensor is named",
    }
}

impl NoiseConfig {
    /// The errors as simulator settings.
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

    /// The range of depths that the camera measures: unlimited without errors.
    pub fn depth_range(&self) -> DepthRange {
        self.noise().depth.map_or_else(DepthRange::default, |depth| depth.range())
    }

    /// Whether frames claim wrong poses.
    pub fn is_pose_wrong(&self) -> bool {
        self.pose_error_mm > 0.0 || self.pose_error_deg > 0.0
    }

    /// All values out of range, including those of a disabled model.
    pub(crate) fn faults(&self) -> Vec<Fault> {
        let limit_deg = 1_f64.to_degrees().floor();
        let errors = [
            ("noise.pose_error_mm", self.pose_error_mm, 1000.0),
            ("noise.pose_error_deg", self.pose_error_deg, limit_deg),
        ];
        let wrong = errors.into_iter().filter(|(_, value, limit)| !(0.0..=*limit).contains(value));
        let faults = wrong.map(|(key, value, limit)| Fault::of_value(key, value, format!("0 to {limit}")));
        let least = of_least_depth("noise.depth.min_depth_m", self.depth.min_depth);
        faults
            .chain(self.depth.check().err().map(|error| Fault::of_part("noise.depth", error)))
            .chain(least)
            .collect()
    }
}
