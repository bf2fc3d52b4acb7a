use crate::Error;
use crate::checked::{check_range, checked_when_read};
use crate::geometry::Pose;
use serde::{Deserialize, Serialize};

/// The depths that a camera measures, metres. Default: all.
///
/// ```
/// use nextview::sensor::DepthRange;
///
/// // A camera that measures from a quarter of a metre on, and an object of half a metre.
/// let range = DepthRange { min: 0.25, max: 10.0 };
/// assert_eq!(range.distances(0.25), (0.5, 10.0));
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields, remote = "Self")]
pub struct DepthRange {
    /// Smallest measured depth, at least 0.
    #[serde(rename = "min_m")]
    pub min: f64,
    /// Largest measured depth, above `min` and at most [`Pose::REACH`].
    #[serde(rename = "max_m")]
    pub max: f64,
}

checked_when_read!(DepthRange);

impl Default for DepthRange {
    fn default() -> Self {
        Self { min: 0.0, max: Pose::REACH }
    }
}

impl DepthRange {
    /// Fails unless `0 <= min < max`, and both are finite.
    pub fn check(&self) -> Result<(), Error> {
        check_range("min_m", self.min, 0.0..=Pose::REACH, "0 or a positive number of metres")?;
        match self.min < self.max && self.max <= Pose::REACH {
            true => Ok(()),
            false => Err(Error::invalid("max_m", self.max, "a finite number of metres above min_m")),
        }
    }

    /// Returns the smallest and the largest distance, metres, of a view from the centre of an object with
    /// this half-side: at the smallest, the camera still measures the object's near side; at the largest, its
    /// centre. If the object is too large for both, they are equal.
    pub fn distances(&self, size: f64) -> (f64, f64) {
        let nearest = if self.min > 0.0 { self.min + size } else { 0.0 };
        (nearest, self.max.max(nearest))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn refuses_what_is_no_range() {
        assert!(DepthRange::default().check().is_ok());
        for (min, max) in [(-0.1, 1.0), (0.5, 0.5), (0.0, f64::INFINITY), (f64::NAN, 1.0), (0.1, f64::NAN)] {
            assert!(DepthRange { min, max }.check().is_err(), "{min} to {max}");
        }
    }

    #[test]
    fn without_a_minimum_every_distance_will_do() {
        assert_eq!(DepthRange::default().distances(0.1), (0.0, Pose::REACH));
        let close = DepthRange { min: 0.4, max: 0.5 };
        assert_eq!(close.distances(0.3), (0.7, 0.7));
    }
}
