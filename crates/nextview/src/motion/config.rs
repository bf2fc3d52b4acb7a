use crate::Error;
use crate::checked::{check_range, checked_when_read};
use serde::{Deserialize, Serialize};

/// Speed, clearance and dwell time of the camera.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields, remote = "Self")]
pub struct MotionConfig {
    /// Maximum speed, metres per second, 0.001..=100. Default 0.25: the limit of ISO 10218 for a robot at
    /// reduced speed, with people around.
    #[serde(rename = "speed_m_per_s")]
    pub speed: f64,
    /// Maximum acceleration along the path, and across it on arcs, metres per second squared, 0.001..=100.
    /// Default 0.5: full speed after half a second, a twentieth of gravity, so that nothing sways when it
    /// stops.
    #[serde(rename = "acceleration_m_per_s2")]
    pub acceleration: f64,
    /// Distance from the ball around the object's box, metres, 0..=1e6. Default 0.02: most of the depth of a
    /// small camera, as above tables.
    #[serde(rename = "clearance_m")]
    pub clearance: f64,
    /// Time that the robot stands at each view, seconds, at least 0. Default 2: one second for the arm to
    /// stop swaying and one for the image, or the mean of thirty. Not part of trajectories.
    #[serde(rename = "sensing_time_s")]
    pub sensing_time: f64,
}

checked_when_read!(MotionConfig);

impl Default for MotionConfig {
    fn default() -> Self {
        Self { speed: 0.25, acceleration: 0.5, clearance: 0.02, sensing_time: 2.0 }
    }
}

impl MotionConfig {
    /// Fails on the first value out of range.
    pub fn check(&self) -> Result<(), Error> {
        let limit = 0.001..=100.0;
        check_range("speed_m_per_s", self.speed, limit.clone(), "0.001 to 100")?;
        check_range("acceleration_m_per_s2", self.acceleration, limit, "0.001 to 100")?;
        check_range("clearance_m", self.clearance, 0.0..=1e6, "0 to 1e6")?;
        check_range("sensing_time_s", self.sensing_time, 0.0..=f64::MAX, "a number of at least 0")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn refuses_what_is_out_of_range() {
        assert!(MotionConfig::default().check().is_ok());
        for bad in [f64::NAN, 0.0, -1.0, 1e-9, f64::INFINITY] {
            assert!(MotionConfig { speed: bad, ..Default::default() }.check().is_err());
            assert!(MotionConfig { acceleration: bad, ..Default::default() }.check().is_err());
        }
        for bad in [f64::NAN, -0.1, f64::INFINITY] {
            assert!(MotionConfig { sensing_time: bad, ..Default::default() }.check().is_err());
        }
        let error = MotionConfig { clearance: -0.1, ..Default::default() }.check().unwrap_err();
        assert_eq!(error.to_string(), "clearance_m is -0.1, expected 0 to 1e6");
    }
}
