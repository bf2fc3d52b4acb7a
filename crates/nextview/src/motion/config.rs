use crate::Error;

/// How fast the camera moves, and how far it keeps away.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MotionConfig {
    /// Highest speed, metres a second, 0.001..=100. Default 0.25: what ISO 10218 allows a robot at reduced speed, with people
    /// around.
    pub speed: f64,
    /// Highest acceleration along the way, and across it where it is an arc, metres a second squared, 0.001..=100. Default 0.5:
    /// full speed after half a second, a twentieth of gravity, so that nothing sways when it stops.
    pub acceleration: f64,
    /// Distance from the ball around the object's box, metres, at least 0. Default 0.02: most of the depth of a small camera, as
    /// above tables.
    pub clearance: f64,
}

impl Default for MotionConfig {
    fn default() -> Self {
        Self { speed: 0.25, acceleration: 0.5, clearance: 0.02 }
    }
}

impl MotionConfig {
    /// Fails on the first value out of range.
    pub fn check(&self) -> Result<(), Error> {
        for (name, value) in [("speed", self.speed), ("acceleration", self.acceleration)] {
            if !(0.001..=100.0).contains(&value) {
                return Err(Error::invalid(name, value, "0.001 to 100 (metres and seconds)"));
            }
        }
        if !(self.clearance >= 0.0 && self.clearance.is_finite()) {
            return Err(Error::invalid("clearance", self.clearance, "a length in metres, at least 0"));
        }
        Ok(())
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
        let error = MotionConfig { clearance: -0.1, ..Default::default() }.check().unwrap_err();
        assert_eq!(error.to_string(), "clearance is -0.1, expected a length in metres, at least 0");
    }
}
