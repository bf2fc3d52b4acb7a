use nextview::Error;
use nextview::sensor::{DepthNoise, DepthRange, Principle, Sensor, SurfaceNoise};
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::f64::consts::{FRAC_PI_2, PI};

/// Errors and losses of a depth camera: noise of the disparity or of the depth itself, optionally shared by
/// neighbouring pixels; depths taken from neighbouring pixels, or between two of them; losses to occlusion of
/// a second camera or projector, at edges, at grazing angles, near by and far away; and rounding.
///
/// The same steps model stereo, structured light and time of flight: each uses the parts that are not 0. The
/// default is [`d435i`](Self::d435i); [`of`](Self::of) has every [`Sensor`].
///
/// Lost pixels and the source of each depth are decided before the axial error, so the true measurement is
/// known.
///
/// ```
/// use nextview_sim::noise::SensorNoise;
///
/// let noise = SensorNoise::d435i();
/// // 0.94 mm at half a metre, four times as much at twice the distance.
/// assert!((noise.axial_sigma(0.5) - 0.000_943).abs() < 1e-6);
/// assert!((noise.axial_sigma(1.0) / noise.axial_sigma(0.5) - 4.0).abs() < 1e-9);
/// assert_eq!((noise.grazing_loss(1.0), noise.grazing_loss(1.6)), (0.0, 1.0));
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields, remote = "Self")]
pub struct SensorNoise {
    /// Distance from the camera to the second camera or projector at its right, metres; 0 if there is none:
    /// nothing is hidden and there is no disparity. Default 0.05.
    #[serde(rename = "baseline_m")]
    pub baseline: f64,
    /// Focal length of the matched images, pixels, above 0. They may be larger than the depth image. Default
    /// 424.
    #[serde(rename = "focal_px")]
    pub focal: f64,
    /// Standard deviation of the disparity, pixels of the matched images, 0 or more. Default 0.08.
    #[serde(rename = "disparity_sigma_px")]
    pub disparity_sigma: f64,
    /// Step to which the disparity is rounded, pixels of the matched images; 0 does not round. Default 1/32.
    #[serde(rename = "disparity_step_px")]
    pub disparity_step: f64,
    /// Step to which the depth is rounded, metres; 0 does not round. Default 0.001.
    #[serde(rename = "depth_unit_m")]
    pub depth_unit: f64,
    /// Minimum depth, metres, 0 or more; nearer surfaces are lost. Default 0.17.
    #[serde(rename = "min_depth_m")]
    pub min_depth: f64,
    /// Maximum depth, metres, above `min_depth`; farther surfaces are lost. Default 10.
    #[serde(rename = "max_depth_m")]
    pub max_depth: f64,
    /// Standard deviation of the offset, in both directions, to the pixel whose depth a pixel shows, pixels
    /// of the depth image, 0..=4. Default 0.5.
    #[serde(rename = "lateral_sigma_px")]
    pub lateral_sigma: f64,
    /// Change of the disparity from one pixel to the next above which pixels are next to an edge, above 0. It
    /// is a gradient, independent of the image size. Default 1.
    pub edge_gradient: f64,
    /// Probability that a pixel next to an edge is lost, 0..=1. Default 0.5.
    pub edge_loss: f64,
    /// Angle between ray and surface normal above which pixels may be lost, radians, 0..pi/2. Default 70
    /// degrees.
    #[serde(rename = "grazing_from_rad")]
    pub grazing_from: f64,
    /// Share of the axial variance that neighbouring pixels have in common, 0..=1: real surfaces of stereo
    /// cameras are wavy rather than rough. Default 0.
    pub correlated_share: f64,
    /// Distance at which the correlation of the common part has fallen to 1/e, pixels of the depth image; at
    /// a distance r it is exp(-(r / d)^2), where d is this distance. 1..=100. Default 7.
    #[serde(rename = "correlation_px")]
    pub correlation: f64,
    /// Probability that a pixel next to a depth jump is a flying pixel, with a depth between both sides,
    /// 0..=1. Default 0.
    pub flying_share: f64,
    /// Minimum step to the next pixel that is a jump, as a share of the nearer depth, above 0. Default 0.02.
    pub flying_jump: f64,
    /// Depth error in addition to that of the disparity. Default none.
    pub error: DepthNoise,
}

impl Serialize for SensorNoise {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        Self::serialize(self, serializer)
    }
}

impl<'de> Deserialize<'de> for SensorNoise {
    /// Fails on a value out of range.
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let noise = Self::deserialize(deserializer)?;
        noise.check().map_err(serde::de::Error::custom)?;
        Ok(noise)
    }
}

impl Default for SensorNoise {
    fn default() -> Self {
        Self::d435i()
    }
}

impl SensorNoise {
    /// Returns the noise of the RealSense D435i in its best depth mode, 848 x 480, whatever the size of the
    /// image derived from it.
    ///
    /// Published: the baseline (data sheet); the focal length, half of 848 pixels over the tangent of half of
    /// 90 degrees, and the step of 1/32 pixel (Intel, subpixel linearity white paper); the noise of 0.08
    /// pixel, the minimum depth of 17 cm and the unit of 1 mm (Grunnet-Jepsen of Intel, librealsense issues
    /// 3904 and 999); the lateral noise (Barron & Malik 2013 and Handa et al. 2014, for the Kinect); the
    /// disparity gradient limit of 1 (Burt & Julesz 1980). Chosen by us: the loss of half of the pixels next
    /// to an edge, and the angle of 70 degrees.
    pub const fn d435i() -> Self {
        Self {
            baseline: 0.05,
            focal: 424.0,
            disparity_sigma: 0.08,
            disparity_step: 1.0 / 32.0,
            depth_unit: 0.001,
            min_depth: 0.17,
            max_depth: 10.0,
            lateral_sigma: 0.5,
            edge_gradient: 1.0,
            edge_loss: 0.5,
            grazing_from: 70.0 / 180.0 * PI,
            correlated_share: 0.0,
            correlation: MATCHED_PX,
            flying_share: 0.0,
            flying_jump: 0.02,
            error: DepthNoise { constant: 0.0, linear: 0.0, quadratic: 0.0 },
        }
    }

    /// Returns the realistic noise of a sensor; that of the D435i has waves, unlike [`d435i`](Self::d435i).
    ///
    /// Published: the values of the [`Sensor`]. Chosen by us: see `docs/noise.md`.
    pub fn of(sensor: Sensor) -> Self {
        let (range, intrinsics) = (sensor.depth_range(), sensor.intrinsics());
        let (min_depth, max_depth, depth_unit) = (range.min, range.max, sensor.depth_unit());
        let common = Self { min_depth, max_depth, depth_unit, ..Self::d435i() };
        let alone = Self { disparity_sigma: 0.0, disparity_step: 0.0, error: sensor.depth_error(), ..common };
        match sensor.principle() {
            Principle::Stereo { baseline, focal, disparity_sigma } => {
                let correlation = (10.0 * MATCHED_PX * intrinsics.focal().x / focal).round() / 10.0;
                Self { baseline, focal, disparity_sigma, correlated_share: 0.8, correlation, ..common }
            }
            Principle::StructuredLight { baseline, focal } => {
                Self { baseline, focal, edge_loss: 0.0, lateral_sigma: 0.25, ..alone }
            }
            _ => Self { baseline: 0.0, focal: intrinsics.focal().x, flying_share: 0.5, ..alone },
        }
    }

    /// Fails on the first field out of range.
    pub fn check(&self) -> Result<(), Error> {
        let check = |name, value: f64, is_fine: bool, expected| match is_fine && value.is_finite() {
            true => Ok(()),
            false => Err(Error::InvalidParameter { name, value: value.to_string(), expected }),
        };
        let positive = |name, value, expected| check(name, value, value > 0.0, expected);
        let from_0 = |name, value, expected| check(name, value, value >= 0.0, expected);
        from_0("baseline_m", self.baseline, "0 or a positive number of metres")?;
        positive("focal_px", self.focal, "a positive number of pixels")?;
        from_0("disparity_sigma_px", self.disparity_sigma, "0 or a positive number of pixels")?;
        from_0("disparity_step_px", self.disparity_step, "0 or a positive number of pixels")?;
        let has_disparity = self.disparity_sigma > 0.0 || self.disparity_step > 0.0;
        let without = "a positive number of metres, or no disparity_sigma_px and disparity_step_px";
        check("baseline_m", self.baseline, self.baseline > 0.0 || !has_disparity, without)?;
        from_0("depth_unit_m", self.depth_unit, "0 or a positive number of metres")?;
        from_0("min_depth_m", self.min_depth, "0 or a positive number of metres")?;
        let is_range = self.range().check().is_ok();
        check("max_depth_m", self.max_depth, is_range, "a number of metres above min_depth_m")?;
        let lateral = (0.0..=4.0).contains(&self.lateral_sigma);
        check("lateral_sigma_px", self.lateral_sigma, lateral, "0 to 4 pixels")?;
        positive("edge_gradient", self.edge_gradient, "a positive number")?;
        check("edge_loss", self.edge_loss, (0.0..=1.0).contains(&self.edge_loss), "a probability in 0..=1")?;
        let grazing = (0.0..FRAC_PI_2).contains(&self.grazing_from);
        check("grazing_from_rad", self.grazing_from, grazing, "0 to less than pi/2 (1.5708) radians")?;
        let correlated = (0.0..=1.0).contains(&self.correlated_share);
        check("correlated_share", self.correlated_share, correlated, "a share in 0..=1")?;
        let correlation = (1.0..=100.0).contains(&self.correlation);
        check("correlation_px", self.correlation, correlation, "1 to 100 pixels")?;
        let flying = (0.0..=1.0).contains(&self.flying_share);
        check("flying_share", self.flying_share, flying, "a probability in 0..=1")?;
        positive("flying_jump", self.flying_jump, "a positive number")?;
        self.error.check()
    }

    /// Returns the range of depths that are not lost.
    pub fn range(&self) -> DepthRange {
        DepthRange { min: self.min_depth, max: self.max_depth }
    }

    /// Returns the random depth error before rounding: the error of the disparity `d = f b / z`, which is
    /// `z^2 sigma_d / (f b)`, plus the additional one.
    pub fn depth_error(&self) -> DepthNoise {
        if self.baseline == 0.0 {
            return self.error;
        }
        let stereo = DepthNoise::of_disparity(self.disparity_sigma, self.focal, self.baseline);
        DepthNoise { quadratic: self.error.quadratic + stereo.quadratic, ..self.error }
    }

    /// Returns the standard deviation of the depth at this depth, both in metres, before rounding.
    pub fn axial_sigma(&self, depth: f64) -> f64 {
        self.depth_error().sigma(depth)
    }

    /// Returns the error of a measured surface according to the camera's data, including rounding of the
    /// disparity.
    pub fn surface_error(&self) -> SurfaceNoise {
        let mut depth = self.depth_error();
        if self.baseline > 0.0 {
            let rounding = self.disparity_step / 12_f64.sqrt();
            let sigma = self.disparity_sigma.hypot(rounding);
            depth.quadratic += (sigma - self.disparity_sigma) / (self.focal * self.baseline);
        }
        SurfaceNoise {
            depth,
            correlated_share: self.correlated_share,
            depth_unit: self.depth_unit,
            lateral_sigma: self.lateral_sigma,
        }
    }

    /// Returns the probability, 0..=1, that a pixel is lost at this angle between its ray and the surface's
    /// normal, radians. It rises linearly from 0 at `grazing_from` to 1 at a right angle.
    pub fn grazing_loss(&self, angle: f64) -> f64 {
        ((angle - self.grazing_from) / (FRAC_PI_2 - self.grazing_from)).clamp(0.0, 1.0)
    }

    /// The measured depth, metres, of a surface at this depth with an error of this many sigmas towards the
    /// camera; NaN if no disparity or depth remains.
    pub(super) fn reported(&self, depth: f64, sigmas: f64) -> f32 {
        let told = self.triangulated(depth, sigmas) - self.error.sigma(depth) * sigmas;
        if told > 0.0 { rounded(told, self.depth_unit) as f32 } else { f32::NAN }
    }

    /// The depth, metres, from a disparity with an error of this many sigmas; NaN if no disparity remains.
    fn triangulated(&self, depth: f64, sigmas: f64) -> f64 {
        if self.baseline == 0.0 {
            return depth;
        }
        let at_1_m = self.focal * self.baseline;
        let disparity = rounded(at_1_m / depth + self.disparity_sigma * sigmas, self.disparity_step);
        if disparity > 0.0 { at_1_m / disparity } else { f64::NAN }
    }
}

/// Width of the stereo matching window, pixels of the matched images.
const MATCHED_PX: f64 = 7.0;

/// The nearest multiple of the step; 0 does not round.
fn rounded(value: f64, step: f64) -> f64 {
    if step > 0.0 { (value / step).round() * step } else { value }
}
