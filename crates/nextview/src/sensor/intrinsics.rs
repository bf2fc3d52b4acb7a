use super::Distortion;
use crate::Error;
use glam::{DVec2, DVec3};
use serde::{Deserialize, Serialize};

/// The optics of a camera: image size, focal lengths, principal point and lens distortion, in pixels.
///
/// A pixel's centre has integer coordinates, as in OpenCV and librealsense.
///
/// ```
/// use glam::{DVec2, DVec3};
/// use nextview::sensor::Intrinsics;
///
/// let camera = Intrinsics::pinhole(640, 480, DVec2::splat(600.0), DVec2::new(320.0, 240.0)).unwrap();
/// let pixel = camera.project(DVec3::new(0.1, 0.0, 0.5)).unwrap();
/// assert_eq!(pixel, DVec2::new(440.0, 240.0));
/// assert_eq!(camera.deproject(pixel), Some(DVec2::new(0.2, 0.0)));
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(try_from = "Fields", into = "Fields")]
pub struct Intrinsics {
    width: u32,
    height: u32,
    focal: DVec2,
    center: DVec2,
    distortion: Distortion,
}

/// Largest width and height, pixels.
const MAX_SIZE: u32 = 1 << 15;

/// Smallest focal length in widths or heights of the image: below it, the field of view exceeds 179 degrees.
const LEAST_FOCAL: f64 = 1.0 / 250.0;

/// Largest focal length, pixels: beyond it, a pixel is below a ten thousandth of a degree.
const MAX_FOCAL: f64 = 1e6;

impl Intrinsics {
    /// Returns an ideal pinhole camera: image size in pixels, focal lengths `fx, fy` and principal point `cx,
    /// cy` in pixels. Fails with the first error of [`check`](Self::check).
    pub fn pinhole(width: u32, height: u32, focal: DVec2, center: DVec2) -> Result<Self, Error> {
        match Self::check(width, height, focal, center).into_iter().next() {
            Some(error) => Err(error),
            None => Ok(Self { width, height, focal, center, distortion: Distortion::None }),
        }
    }

    /// Returns all errors in the values of a pinhole camera, each under its name in a file.
    pub fn check(width: u32, height: u32, focal: DVec2, center: DVec2) -> Vec<Error> {
        let sizes = [("width", width), ("height", height)].into_iter();
        let sizes = sizes.filter(|(_, size)| !(1..=MAX_SIZE).contains(size));
        let sizes = sizes.map(|(name, size)| Error::invalid(name, size, "1 to 32768 pixels"));
        let focals = [("fx", focal.x, width), ("fy", focal.y, height)].into_iter();
        let has_view = |focal: f64, size: u32| focal >= LEAST_FOCAL * f64::from(size) && focal <= MAX_FOCAL;
        let focals = focals.filter(|(_, focal, size)| !(*focal > 0.0 && has_view(*focal, *size)));
        let focals = focals.map(|(name, focal, _)| {
            Error::invalid(
                name,
                format!("{focal:?}"),
                "a positive number of pixels, at least 1/250 of the image, at most 1e6",
            )
        });
        let centers = [("cx", center.x, width), ("cy", center.y, height)].into_iter();
        let most = f64::from(MAX_SIZE);
        let centers = centers.filter(|(_, at, size)| !(-most..=most + f64::from(*size)).contains(at));
        let centers = centers.map(|(name, at, _)| {
            Error::invalid(name, format!("{at:?}"), "a pixel, at most 32768 outside the image")
        });
        sizes.chain(focals).chain(centers).collect()
    }

    /// Sets the lens distortion; its coefficients must be finite.
    pub fn with_distortion(mut self, distortion: Distortion) -> Result<Self, Error> {
        distortion.check()?;
        self.distortion = distortion;
        Ok(self)
    }

    /// Returns the paper's RealSense D435i, 640 x 480, with the calibration from the configuration file of
    /// its authors' code (psc0628/NBV-Simulation, `DefaultConfiguration.yaml`). The coefficients are listed
    /// there as k1, k2, k3, p1, p2 and passed in that order to librealsense, which reads them as k1, k2, p1,
    /// p2, k3; so do we.
    pub fn d435i() -> Self {
        Self {
            width: 640,
            height: 480,
            focal: DVec2::new(610.404_479_980_468_8, 608.884_460_449_218_8),
            center: DVec2::new(324.763_549_804_687_5, 248.343_536_376_953_1),
            distortion: Distortion::InverseBrownConrady([
                0.120_421_998_202_800_75,
                -0.213_734_999_299_049_38,
                0.005_386_000_033_468_008,
                -0.002_121_000_085_026_025_8,
                0.0,
            ]),
        }
    }

    /// Returns the image width in pixels.
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Returns the image height in pixels.
    pub fn height(&self) -> u32 {
        self.height
    }

    /// Returns the number of pixels.
    pub fn n_pixels(&self) -> usize {
        self.width as usize * self.height as usize
    }

    /// Returns the focal lengths `fx, fy` in pixels.
    pub fn focal(&self) -> DVec2 {
        self.focal
    }

    /// Returns the principal point `cx, cy` in pixels.
    pub fn center(&self) -> DVec2 {
        self.center
    }

    /// Returns the lens distortion.
    pub fn distortion(&self) -> Distortion {
        self.distortion
    }

    /// Projects a point of the camera frame to a pixel; `None` behind the camera or if the lens model has no
    /// answer. The pixel may be outside the image, see [`contains`](Self::contains).
    pub fn project(&self, point_in_camera: DVec3) -> Option<DVec2> {
        if point_in_camera.z <= 0.0 {
            return None;
        }
        let ideal = point_in_camera.truncate() / point_in_camera.z;
        Some(self.distortion.distort(ideal)? * self.focal + self.center)
    }

    /// Returns the point where a pixel's ray crosses the plane z = 1 of the camera frame: the exact inverse
    /// of [`project`](Self::project). The point at depth `z` is `z * (x, y, 1)`.
    pub fn deproject(&self, pixel: DVec2) -> Option<DVec2> {
        self.distortion.undistort((pixel - self.center) / self.focal)
    }

    /// Returns the maximum stretch by the lens; `None` if it folds within the image or just outside it.
    pub fn stretch(&self) -> Option<Stretch> {
        let last = DVec2::new(self.width as f64, self.height as f64) - 0.5;
        let farthest = (last - self.center).max(self.center + 0.5);
        // Slightly more than the image, whose corners a lens may move outwards.
        let radius = 1.1 * (farthest / self.focal).length();
        self.distortion.stretch(radius).map(|factor| Stretch { radius, factor })
    }

    /// Whether a pixel coordinate is in the image.
    pub fn contains(&self, pixel: DVec2) -> bool {
        let size = DVec2::new(self.width as f64, self.height as f64);
        pixel.cmpge(DVec2::splat(-0.5)).all() && pixel.cmplt(size - 0.5).all()
    }
}

/// The maximum stretch by a lens: for two points of the plane z = 1 within this radius of the optical axis
/// and visible in the image, the images on that plane are at most `factor` times as far apart as the points.
#[derive(Clone, Copy, Debug)]
pub struct Stretch {
    /// Distance from the optical axis on the plane z = 1.
    pub radius: f64,
    /// At least as large as the stretch anywhere within the radius; 1 without distortion.
    pub factor: f64,
}

/// The optics of a camera, in pixels. A pixel's centre has integer coordinates.
#[derive(Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema), schemars(rename = "Intrinsics"))]
#[serde(deny_unknown_fields)]
struct Fields {
    /// Image width, pixels, 1 to 32768.
    width: u32,
    /// Image height, pixels, 1 to 32768.
    height: u32,
    /// Focal length along rows, pixels, 1/250 of the width to 1e6.
    fx: f64,
    /// Focal length along columns, pixels, 1/250 of the height to 1e6.
    fy: f64,
    /// Column of the principal point, pixels, at most 32768 outside the image.
    cx: f64,
    /// Row of the principal point, pixels, at most 32768 outside the image.
    cy: f64,
    /// Lens distortion. Default: none.
    #[serde(default)]
    distortion: Distortion,
}

impl TryFrom<Fields> for Intrinsics {
    type Error = Error;

    fn try_from(f: Fields) -> Result<Self, Error> {
        Self::pinhole(f.width, f.height, DVec2::new(f.fx, f.fy), DVec2::new(f.cx, f.cy))?
            .with_distortion(f.distortion)
    }
}

impl From<Intrinsics> for Fields {
    fn from(i: Intrinsics) -> Self {
        let Intrinsics { width, height, focal, center, distortion } = i;
        Self { width, height, fx: focal.x, fy: focal.y, cx: center.x, cy: center.y, distortion }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_pixel_of_the_preset_survives_a_round_trip() {
        let camera = Intrinsics::d435i();
        for v in (0..480).step_by(7) {
            for u in (0..640).step_by(7) {
                let pixel = DVec2::new(u as f64, v as f64);
                let ideal = camera.deproject(pixel).unwrap();
                let back = camera.project((ideal * 0.37).extend(0.37)).unwrap();
                assert!(back.distance(pixel) < 1e-9, "{pixel} came back as {back}");
            }
        }
    }

    #[test]
    fn points_behind_the_camera_have_no_pixel() {
        assert_eq!(Intrinsics::d435i().project(DVec3::new(0.0, 0.0, -1.0)), None);
        assert_eq!(Intrinsics::d435i().project(DVec3::ZERO), None);
    }

    #[test]
    fn refuses_what_is_no_camera() {
        let center = DVec2::splat(10.0);
        assert!(Intrinsics::pinhole(0, 480, DVec2::ONE, center).is_err());
        assert!(Intrinsics::pinhole(640, 480, DVec2::new(600.0, 0.0), center).is_err());
        assert!(Intrinsics::pinhole(640, 480, DVec2::splat(600.0), DVec2::NAN).is_err());
        let wrong = Intrinsics::check(640, 0, DVec2::new(1e300, -1e-9), DVec2::new(1e300, -1e5));
        let names = ["height is 0,", "fx is 1e300,", "fy is -1e-9,", "cx is 1e300,", "cy is -100000.0,"];
        assert!(wrong.iter().map(Error::to_string).zip(names).all(|(error, name)| error.starts_with(name)));
        assert_eq!(wrong.len(), names.len(), "{wrong:?}");
        // A crop of the corner of a large image.
        assert!(Intrinsics::pinhole(1, 1, DVec2::splat(3e4), DVec2::splat(-16384.0)).is_ok());
        let bad = Distortion::BrownConrady([f64::NAN, 0.0, 0.0, 0.0, 0.0]);
        assert!(Intrinsics::d435i().with_distortion(bad).is_err());
    }
}
