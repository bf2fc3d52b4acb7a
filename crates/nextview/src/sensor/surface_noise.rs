use super::DepthNoise;
use crate::Error;
use crate::checked::{check_range, checked_when_read};
use serde::{Deserialize, Serialize};

/// The random error of a measured surface along its normal, from a camera's specification, for one pixel and
/// for many pixels of one image. Default: none.
///
/// ```
/// use nextview::sensor::{DepthNoise, SurfaceNoise};
///
/// let depth = DepthNoise { constant: 0.001, ..DepthNoise::default() };
/// let error = SurfaceNoise { depth, correlated_share: 0.25, ..SurfaceNoise::default() };
/// let pixel = error.of_pixel(0.5, 1.0, 600.0);
/// assert!((pixel.sqrt() - 0.001).abs() < 1e-12);
/// // The mean of many neighbouring pixels still has what they share: half of the standard deviation.
/// assert!((error.of_look(pixel, 1e9).sqrt() - 0.0005).abs() < 1e-9);
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields, remote = "Self")]
pub struct SurfaceNoise {
    /// Random error of the depth.
    pub depth: DepthNoise,
    /// Share of its variance that neighbouring pixels of an image have in common, 0..=1. Default 0.
    pub correlated_share: f64,
    /// Unit to which depths are rounded, metres; 0 does not round. Default 0.
    #[serde(rename = "depth_unit_m")]
    pub depth_unit: f64,
    /// Standard deviation, in both directions, of the lateral shift of a pixel's depth, pixels, 0 or more.
    /// Default 0.
    #[serde(rename = "lateral_sigma_px")]
    pub lateral_sigma: f64,
}

checked_when_read!(SurfaceNoise);

/// Flatter angles than this cosine count as this one: pixels there are not trusted.
const LEAST_COSINE: f64 = 0.2;

impl SurfaceNoise {
    /// Returns the error of an unknown camera: that of a first Kinect, 1.4 mm at 1 m and growing with the
    /// square of the depth (Khoshelham & Elberink, Sensors 2012), four fifths of it shared by neighbouring
    /// pixels, plus 1 mm for calibration and poses.
    pub fn of_unknown_camera() -> Self {
        let depth = DepthNoise { constant: 1e-3, quadratic: 1.425e-3, ..DepthNoise::default() };
        Self { depth, correlated_share: 0.8, ..Self::default() }
    }

    /// Fails on the first value out of range.
    pub fn check(&self) -> Result<(), Error> {
        let from_0 = 0.0..=f64::MAX;
        self.depth.check()?;
        check_range("correlated_share", self.correlated_share, 0.0..=1.0, "a number in 0..=1")?;
        check_range("depth_unit_m", self.depth_unit, from_0.clone(), "0 or a positive number of metres")?;
        check_range("lateral_sigma_px", self.lateral_sigma, from_0, "0 or a positive number of pixels")
    }

    /// Returns the variance of one pixel along the surface's normal, square metres, for a surface at this
    /// depth (metres, along the optical axis), seen at this cosine between its normal and the ray, in an
    /// image of this focal length (pixels), before the depth is rounded. A lateral shift counts by the slope
    /// of the surface.
    pub fn of_pixel(&self, depth: f64, cosine: f64, focal: f64) -> f64 {
        let cosine = cosine.clamp(LEAST_COSINE, 1.0);
        let slope_sq = 1.0 / (cosine * cosine) - 1.0;
        let along_axis = self.depth.sigma(depth).powi(2);
        let lateral = slope_sq * (self.lateral_sigma * depth / focal).powi(2);
        cosine * cosine * (along_axis + lateral)
    }

    /// Returns the variance of the mean of `n` neighbouring pixels of one image, square metres, each with
    /// this variance.
    ///
    /// Rounding errors are shared: these pixels were rounded into the same layer.
    pub fn of_look(&self, of_pixel: f64, n: f64) -> f64 {
        let rounding = self.depth_unit.powi(2) / 12.0;
        of_pixel * (self.correlated_share + (1.0 - self.correlated_share) / n.max(1.0)) + rounding
    }

    /// As [`of_look`](Self::of_look), for a surface at this cosine: rounding, which is along the optical
    /// axis, counts by its component along the normal.
    pub(crate) fn of_look_at(&self, of_pixel: f64, n: f64, cosine: f64) -> f64 {
        let rounding = self.depth_unit.powi(2) / 12.0;
        self.of_look(of_pixel, n) - rounding * (1.0 - cosine.clamp(LEAST_COSINE, 1.0).powi(2))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_slope_shortens_the_depth_error_and_lets_the_lateral_one_in() {
        let depth = DepthNoise { constant: 0.001, ..DepthNoise::default() };
        let error = SurfaceNoise { depth, ..SurfaceNoise::default() };
        assert!((error.of_pixel(1.0, 0.5, 500.0).sqrt() - 0.0005).abs() < 1e-12);
        let lateral = SurfaceNoise { lateral_sigma: 1.0, ..SurfaceNoise::default() };
        assert_eq!(lateral.of_pixel(1.0, 1.0, 500.0), 0.0);
        // At 45 degrees, 2 mm sideways are 2 mm deeper, and 1.41 mm along the normal.
        let at_45 = lateral.of_pixel(1.0, 0.5_f64.sqrt(), 500.0).sqrt();
        assert!((at_45 - 0.002 * 0.5_f64.sqrt()).abs() < 1e-12, "{at_45}");
    }

    #[test]
    fn values_out_of_range_are_named() {
        let none = SurfaceNoise::default();
        assert!(none.check().is_ok());
        for (error, name) in [
            (SurfaceNoise { correlated_share: 1.1, ..none }, "correlated_share is 1.1"),
            (SurfaceNoise { depth_unit: -1.0, ..none }, "depth_unit_m is -1"),
            (SurfaceNoise { lateral_sigma: f64::NAN, ..none }, "lateral_sigma_px is NaN"),
        ] {
            assert!(error.check().unwrap_err().to_string().starts_with(name));
        }
    }
}
