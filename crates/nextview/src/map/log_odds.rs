use crate::Error;
use crate::checked::checked_when_read;
use serde::{Deserialize, Serialize};

/// The logarithm of the odds that a voxel is occupied: 0 is P = 0.5.
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd)]
pub struct LogOdds(pub f32);

impl LogOdds {
    /// Returns the log-odds of a probability in `0..1`, both ends excluded for a finite result.
    pub fn from_probability(p: f64) -> Self {
        Self((p / (1.0 - p)).ln() as f32)
    }

    /// Returns the probability in `0..=1`.
    pub fn probability(self) -> f64 {
        1.0 - 1.0 / (1.0 + (self.0 as f64).exp())
    }
}

/// Returns the entropy of a voxel with occupancy `p`, nats, 0 to ln 2: the first line of the paper's eq. (2).
pub fn entropy(p: f64) -> f64 {
    let part = |q: f64| if q <= 0.0 { 0.0 } else { -q * q.ln() };
    part(p) + part(1.0 - p)
}

/// The effect of a measurement on a voxel: OctoMap's inverse sensor model (Hornung et al. 2013), with its
/// defaults.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields, remote = "Self")]
pub struct SensorModel {
    /// P(occupied) of a voxel in which a ray ends, in 0.5..1. Default 0.7.
    pub hit: f64,
    /// P(occupied) of a voxel that a ray crosses, in 0..0.5. Default 0.4.
    pub miss: f64,
    /// Lower clamp of P(occupied), in 0..0.5. Default 0.1192 (log-odds -2).
    pub clamp_min: f64,
    /// Upper clamp of P(occupied), in 0.5..1. Default 0.971 (log-odds 3.5).
    pub clamp_max: f64,
}

checked_when_read!(SensorModel);

impl Default for SensorModel {
    fn default() -> Self {
        Self { hit: 0.7, miss: 0.4, clamp_min: 0.1192, clamp_max: 0.971 }
    }
}

impl SensorModel {
    /// Fails on the first field out of range.
    pub fn check(&self) -> Result<(), Error> {
        let below = |name, p: f64| {
            (p > 0.0 && p < 0.5)
                .then_some(())
                .ok_or_else(|| Error::invalid(name, p, "a probability in 0..0.5"))
        };
        let above = |name, p: f64| {
            (p > 0.5 && p < 1.0)
                .then_some(())
                .ok_or_else(|| Error::invalid(name, p, "a probability in 0.5..1"))
        };
        above("hit", self.hit)?;
        below("miss", self.miss)?;
        below("clamp_min", self.clamp_min)?;
        above("clamp_max", self.clamp_max)
    }
}

/// The known state of a voxel.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Occupancy {
    /// Never measured (or measured to exactly P = 0.5, which carries no information).
    Unknown,
    /// Measured, P(occupied) below 0.5.
    Free,
    /// Measured, P(occupied) above 0.5.
    Occupied,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn log_odds_and_probability_are_inverses() {
        for p in [0.1192, 0.4, 0.5, 0.7, 0.971] {
            assert!((LogOdds::from_probability(p).probability() - p).abs() < 1e-7);
        }
        assert!((LogOdds::from_probability(0.1192).0 + 2.0).abs() < 1e-4);
    }

    #[test]
    fn entropy_is_ln_2_at_one_half_and_0_at_the_ends() {
        assert_eq!((entropy(0.0), entropy(1.0)), (0.0, 0.0));
        assert!((entropy(0.5) - std::f64::consts::LN_2).abs() < 1e-15);
    }

    #[test]
    fn refuses_a_model_that_learns_backwards() {
        assert!(SensorModel::default().check().is_ok());
        assert!(SensorModel { hit: 0.4, ..Default::default() }.check().is_err());
        assert!(SensorModel { clamp_min: f64::NAN, ..Default::default() }.check().is_err());
    }
}
