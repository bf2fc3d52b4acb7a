use crate::Error;
use crate::checked::{check_range, checked_when_read};
use crate::geometry::Pose;
use serde::{Deserialize, Serialize};

/// The random error of a measured depth: its standard deviation along the optical axis as a function of the
/// depth z (along the same axis, metres), `constant + linear z + quadratic z^2`. Default: none.
///
/// The three terms cover the usual error sources: the noise floor of the electronics (`constant`), time of
/// flight (`linear`), and triangulation (`quadratic`), where the disparity `f b / z` has the same error
/// everywhere. The model holds for a surface that faces the camera; systematic errors, which all pixels
/// share, are not included.
///
/// ```
/// use nextview::sensor::DepthNoise;
///
/// // A stereo camera: 0.08 pixels of disparity, a focal length of 424 pixels, a baseline of 50 mm.
/// let error = DepthNoise::of_disparity(0.08, 424.0, 0.05);
/// assert!((error.sigma(0.5) - 0.000_943).abs() < 1e-6);
/// assert_eq!(error.sigma(1.0), 4.0 * error.sigma(0.5));
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields, remote = "Self")]
pub struct DepthNoise {
    /// Error at depth 0, metres, 0 or more. Default 0.
    #[serde(rename = "constant_m")]
    pub constant: f64,
    /// Error in metres per metre of depth, 0 or more. Default 0.
    pub linear: f64,
    /// Error in metres per squared metre of depth, 1/m, 0 or more. Default 0.
    #[serde(rename = "quadratic_per_m")]
    pub quadratic: f64,
}

checked_when_read!(DepthNoise);

impl DepthNoise {
    /// Returns the error of triangulation, `z^2 sigma_d / (f b)`, from the standard deviation of the
    /// disparity, pixels; the focal length of the matched images, pixels, above 0; and the baseline, metres,
    /// above 0.
    pub fn of_disparity(disparity_sigma: f64, focal: f64, baseline: f64) -> Self {
        Self { quadratic: disparity_sigma / (focal * baseline), ..Self::default() }
    }

    /// Fails unless all terms are finite and at least 0.
    pub fn check(&self) -> Result<(), Error> {
        let terms = [
            ("constant_m", self.constant, "0 or a positive number of metres"),
            ("linear", self.linear, "0 or a positive number"),
            ("quadratic_per_m", self.quadratic, "0 or a positive number a metre"),
        ];
        terms
            .into_iter()
            .try_for_each(|(name, value, expected)| check_range(name, value, 0.0..=Pose::REACH, expected))
    }

    /// Returns the standard deviation at this depth, both in metres.
    pub fn sigma(&self, depth: f64) -> f64 {
        self.constant + depth * (self.linear + depth * self.quadratic)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_terms_add_up() {
        let error = DepthNoise { constant: 0.001, linear: 0.01, quadratic: 0.1 };
        assert!((error.sigma(2.0) - 0.421).abs() < 1e-15);
        assert_eq!(DepthNoise::default().sigma(3.0), 0.0);
    }

    #[test]
    fn terms_out_of_range_are_named() {
        let none = DepthNoise::default();
        assert!(none.check().is_ok());
        for (error, expected) in [
            (DepthNoise { constant: -1.0, ..none }, "constant_m is -1, expected 0 or a positive number of"),
            (DepthNoise { linear: f64::NAN, ..none }, "linear is NaN"),
            (DepthNoise { quadratic: f64::INFINITY, ..none }, "quadratic_per_m is inf"),
        ] {
            let message = error.check().unwrap_err().to_string();
            assert!(message.starts_with(expected), "{message}");
        }
    }
}
