use crate::Error;
use crate::geometry::Lattice;
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// How frames are aligned, and when an alignment is refused.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct RegistrationConfig {
    /// Edge of the cells in which points are pooled, metres, at least 0.0001. Default 0.005: some thousand points for an object
    /// of the size of a hand, each the mean of several pixels of a camera half a metre away.
    pub spacing: f64,
    /// How far a given position may be from the right one, metres, positive; an alignment that moves the camera farther is
    /// refused. Correspondences are searched for as far at first. Default 0.05.
    pub position_uncertainty: f64,
    /// The same for the rotation, radians, above 0 up to pi. Default 10 degrees.
    pub rotation_uncertainty: f64,
    /// Least share, 0..=1, of the frame's points that must lie on the known surface after the alignment. Default 0.3.
    pub min_overlap: f64,
    /// Least [stiffness](super::Registration::stiffness), 0..=1. Default 0.005: what holds a frame less was often turned by
    /// degrees about the axis of a bottle or a handle.
    pub min_stiffness: f64,
}

impl Default for RegistrationConfig {
    fn default() -> Self {
        Self {
            spacing: 0.005,
            position_uncertainty: 0.05,
            rotation_uncertainty: PI / 18.0,
            min_overlap: 0.3,
            min_stiffness: 0.005,
        }
    }
}

impl RegistrationConfig {
    /// Fails on the first value out of range.
    pub fn check(&self) -> Result<(), Error> {
        let check = |name, value: f64, is_fine: bool, expected| match is_fine && value.is_finite() {
            true => Ok(()),
            false => Err(Error::invalid(name, value, expected)),
        };
        let Self { spacing, position_uncertainty: position, rotation_uncertainty: rotation, .. } = *self;
        let is_cell = Lattice::new(spacing).is_ok();
        check("spacing", spacing, is_cell, "a finite length of at least 0.0001 m")?;
        check("position_uncertainty", position, position > 0.0, "a positive number of metres")?;
        let is_angle = rotation > 0.0 && rotation <= PI;
        check("rotation_uncertainty", rotation, is_angle, "above 0 and up to pi radians (180 degrees)")?;
        for (name, share) in [("min_overlap", self.min_overlap), ("min_stiffness", self.min_stiffness)] {
            check(name, share, (0.0..=1.0).contains(&share), "a number in 0..=1")?;
        }
        Ok(())
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
            (RegistrationConfig { spacing: 0.0, ..good }, "spacing is 0"),
            (RegistrationConfig { spacing: f64::NAN, ..good }, "spacing is NaN"),
            (RegistrationConfig { position_uncertainty: 0.0, ..good }, "position_uncertainty is 0"),
            (
                RegistrationConfig { position_uncertainty: f64::INFINITY, ..good },
                "position_uncertainty is inf",
            ),
            (RegistrationConfig { rotation_uncertainty: 3.2, ..good }, "rotation_uncertainty is 3.2"),
            (RegistrationConfig { min_overlap: 1.1, ..good }, "min_overlap is 1.1"),
            (RegistrationConfig { min_stiffness: -0.1, ..good }, "min_stiffness is -0.1"),
        ] {
            assert!(bad.check().unwrap_err().to_string().starts_with(name));
        }
    }
}
