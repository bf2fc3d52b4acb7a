use super::{DepthNoise, DepthRange, Intrinsics};
use crate::Error;
use glam::DVec2;
use std::fmt;
use std::str::FromStr;

/// Common depth cameras, with their published optics, range and noise. `docs/sensors.md` lists sources, and
/// which values are ours.
///
/// ```
/// use nextview::sensor::Sensor;
///
/// let sensor: Sensor = "d405".parse().unwrap();
/// assert_eq!((sensor.intrinsics().width(), sensor.intrinsics().height()), (848, 480));
/// assert_eq!((sensor.depth_range().min, sensor.depth_range().max), (0.07, 0.5));
/// assert!((sensor.depth_error().sigma(0.1) - 0.000_099).abs() < 1e-6);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Sensor {
    /// RealSense D405, stereo for short distances, 848 x 480.
    D405,
    /// RealSense D415, stereo with a narrow field of view, 848 x 480.
    D415,
    /// RealSense D435, stereo with a wide field of view, 848 x 480.
    D435,
    /// RealSense D435i as in the paper, 640 x 480, see [`Intrinsics::d435i`].
    D435i,
    /// RealSense D455, stereo with a long baseline, 848 x 480.
    D455,
    /// RealSense L515, a scanning laser with time of flight, 1024 x 768.
    L515,
    /// Microsoft Azure Kinect, time of flight, narrow field of view, unbinned, 640 x 576.
    AzureKinect,
    /// Orbbec Femto Bolt, with the sensor and the modes of the Azure Kinect.
    FemtoBolt,
    /// Orbbec Gemini 335, stereo, 640 x 400.
    Gemini335,
    /// Zivid 2+ M60, structured light, subsampled 4 x 4 to 612 x 512.
    Zivid2M60,
    /// Photoneo PhoXi 3D Scanner S, structured light, low resolution of 1032 x 772.
    PhoxiS,
    /// Photoneo PhoXi 3D Scanner M, structured light, low resolution of 1032 x 772.
    PhoxiM,
}

/// The measuring principle of a depth camera.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Principle {
    /// Matches two images, the second taken to the right of the first.
    Stereo {
        /// Distance between the two cameras, metres.
        baseline: f64,
        /// Focal length of the matched images, pixels.
        focal: f64,
        /// Standard deviation of the disparity, pixels of the matched images.
        disparity_sigma: f64,
    },
    /// A projector to the right of the camera encodes each point of a surface.
    StructuredLight {
        /// Distance between projector and camera, metres.
        baseline: f64,
        /// Focal length of the depth image, pixels.
        focal: f64,
    },
    /// Light returns along the line of sight.
    TimeOfFlight,
}

impl Sensor {
    /// All sensors, by manufacturer.
    pub const ALL: [Self; 12] = [
        Self::D405,
        Self::D415,
        Self::D435,
        Self::D435i,
        Self::D455,
        Self::L515,
        Self::AzureKinect,
        Self::FemtoBolt,
        Self::Gemini335,
        Self::Zivid2M60,
        Self::PhoxiS,
        Self::PhoxiM,
    ];

    /// Returns the name used in configurations, such as `azure-kinect`.
    pub fn name(self) -> &'static str {
        match self {
            Self::D405 => "d405",
            Self::D415 => "d415",
            Self::D435 => "d435",
            Self::D435i => "d435i",
            Self::D455 => "d455",
            Self::L515 => "l515",
            Self::AzureKinect => "azure-kinect",
            Self::FemtoBolt => "femto-bolt",
            Self::Gemini335 => "gemini-335",
            Self::Zivid2M60 => "zivid-2-m60",
            Self::PhoxiS => "phoxi-s",
            Self::PhoxiM => "phoxi-m",
        }
    }

    /// Returns the optics: a pinhole with the published field of view and the principal point in the middle,
    /// except for the D435i, which has a calibration.
    pub fn intrinsics(self) -> Intrinsics {
        self.sheet().intrinsics.unwrap_or_else(Intrinsics::d435i)
    }

    /// Returns the range of measured depths, metres.
    pub fn depth_range(self) -> DepthRange {
        let [min, max] = self.sheet().range;
        DepthRange { min, max }
    }

    /// Returns the random error of a pixel's depth.
    pub fn depth_error(self) -> DepthNoise {
        match self.principle() {
            Principle::Stereo { baseline, focal, disparity_sigma } => {
                DepthNoise::of_disparity(disparity_sigma, focal, baseline)
            }
            _ => self.sheet().error,
        }
    }

    /// Returns the measuring principle.
    pub fn principle(self) -> Principle {
        self.sheet().principle
    }

    /// Returns the factory unit of its depth images, metres; 0 for floating-point depths.
    pub fn depth_unit(self) -> f64 {
        self.sheet().unit
    }

    fn sheet(self) -> Sheet {
        match self {
            Self::D405 => Sheet { unit: 1e-4, ..stereo([848, 480], [87.0, 58.0], 0.018, [0.07, 0.5]) },
            Self::D415 => stereo([848, 480], [65.0, 40.0], 0.055, [0.31, 10.0]),
            Self::D435 => {
                Sheet { principle: d435_stereo(), ..stereo([848, 480], [87.0, 58.0], 0.05, [0.17, 10.0]) }
            }
            Self::D435i => Sheet { intrinsics: None, ..Self::D435.sheet() },
            Self::D455 => stereo([848, 480], [87.0, 58.0], 0.095, [0.34, 6.0]),
            Self::L515 => {
                let error = DepthNoise { constant: 0.000_875, linear: 0.001_625, quadratic: 0.0 };
                Sheet { unit: 0.000_25, ..time_of_flight([1024, 768], [70.0, 55.0], [0.25, 9.0], error) }
            }
            Self::AzureKinect | Self::FemtoBolt => {
                let error = DepthNoise { constant: 0.000_5, linear: 0.0, quadratic: 0.001 };
                time_of_flight([640, 576], [75.0, 65.0], [0.5, 3.86], error)
            }
            Self::Gemini335 => stereo([640, 400], [90.0, 65.0], 0.05, [0.1, 20.0]),
            Self::Zivid2M60 => {
                let focus = Focus { distance: 0.6, field: [0.57, 0.46], sigma: 0.000_08 };
                structured_light([612, 512], focus, 0.11, [0.35, 1.1])
            }
            Self::PhoxiS => {
                let focus = Focus { distance: 0.442, field: [0.36, 0.2693], sigma: 0.000_05 };
                structured_light([1032, 772], focus, 0.23, [0.384, 0.52])
            }
            Self::PhoxiM => {
                let focus = Focus { distance: 0.65, field: [0.59, 0.4414], sigma: 0.000_1 };
                structured_light([1032, 772], focus, 0.27, [0.458, 1.118])
            }
        }
    }
}

/// The specification of a sensor.
struct Sheet {
    /// `None` for the calibration of the D435i.
    intrinsics: Option<Intrinsics>,
    range: [f64; 2],
    principle: Principle,
    /// The depth error, for principles that do not determine it.
    error: DepthNoise,
    unit: f64,
}

/// A scanner's specification at one distance, all in metres.
struct Focus {
    distance: f64,
    /// Width and height of the field of view there.
    field: [f64; 2],
    /// Standard deviation of the depth there.
    sigma: f64,
}

/// Disparity standard deviation of stereo cameras, pixels.
const DISPARITY_SIGMA: f64 = 0.08;

/// Returns a stereo camera that matches images of the size of the depth image.
fn stereo(size: [u32; 2], view_deg: [f64; 2], baseline: f64, range: [f64; 2]) -> Sheet {
    let intrinsics = pinhole(size, half_tangents(view_deg));
    let focal = intrinsics.focal().x;
    let principle = Principle::Stereo { baseline, focal, disparity_sigma: DISPARITY_SIGMA };
    Sheet { intrinsics: Some(intrinsics), range, principle, error: DepthNoise::default(), unit: 0.001 }
}

/// Returns the principle for matched images 848 pixels and 90 degrees wide.
fn d435_stereo() -> Principle {
    Principle::Stereo { baseline: 0.05, focal: 424.0, disparity_sigma: DISPARITY_SIGMA }
}

fn time_of_flight(size: [u32; 2], view_deg: [f64; 2], range: [f64; 2], error: DepthNoise) -> Sheet {
    let intrinsics = Some(pinhole(size, half_tangents(view_deg)));
    Sheet { intrinsics, range, principle: Principle::TimeOfFlight, error, unit: 0.001 }
}

/// Returns a scanner whose noise grows as in triangulation.
fn structured_light(size: [u32; 2], focus: Focus, baseline: f64, range: [f64; 2]) -> Sheet {
    let intrinsics = pinhole(size, focus.field.map(|length| length / 2.0 / focus.distance));
    let principle = Principle::StructuredLight { baseline, focal: intrinsics.focal().x };
    let error = DepthNoise { quadratic: focus.sigma / focus.distance.powi(2), ..DepthNoise::default() };
    Sheet { intrinsics: Some(intrinsics), range, principle, error, unit: 0.0 }
}

fn half_tangents(view_deg: [f64; 2]) -> [f64; 2] {
    view_deg.map(|degrees| (degrees / 2.0).to_radians().tan())
}

/// Returns a camera whose outermost pixels end at these tangents on both sides of the axis.
fn pinhole([width, height]: [u32; 2], half_tangents: [f64; 2]) -> Intrinsics {
    let size = DVec2::new(width as f64, height as f64);
    let focal = 0.5 * size / DVec2::from_array(half_tangents);
    Intrinsics::pinhole(width, height, focal, 0.5 * (size - 1.0)).expect("the figures are those of a camera")
}

impl fmt::Display for Sensor {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

impl FromStr for Sensor {
    type Err = Error;

    /// Fails if no sensor has this name.
    fn from_str(name: &str) -> Result<Self, Error> {
        let known = Self::ALL.into_iter().find(|sensor| sensor.name() == name);
        known.ok_or_else(|| Error::invalid("sensor", name, NAMES))
    }
}

/// All names, as listed in messages.
const NAMES: &str = "d405, d415, d435, d435i, d455, l515, azure-kinect, femto-bolt, gemini-335, zivid-2-m60, \
                     phoxi-s or phoxi-m";

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_lead_back_to_their_sensors() {
        let names: Vec<&str> = Sensor::ALL.iter().map(|sensor| sensor.name()).collect();
        assert_eq!(NAMES.replace(" or ", ", "), names.join(", "));
        for sensor in Sensor::ALL {
            assert_eq!(sensor.to_string().parse::<Sensor>().unwrap(), sensor);
        }
        let error = "d999".parse::<Sensor>().unwrap_err().to_string();
        assert!(error.starts_with("sensor is d999, expected d405, d415"), "{error}");
    }

    #[test]
    fn all_figures_are_in_range() {
        for sensor in Sensor::ALL {
            assert!(sensor.depth_range().check().is_ok(), "{sensor}");
            assert!(sensor.depth_error().check().is_ok(), "{sensor}");
            let DepthRange { min, max } = sensor.depth_range();
            let sigmas = [min, max].map(|depth| sensor.depth_error().sigma(depth) / depth);
            assert!(sigmas.iter().all(|share| (1e-5..0.12).contains(share)), "{sensor}: {sigmas:?}");
        }
        assert_eq!(Sensor::D435i.intrinsics(), Intrinsics::d435i());
    }

    /// From edge to edge of the outermost pixels, as manufacturers specify it.
    #[test]
    fn the_optics_have_the_published_field_of_view() {
        for (sensor, published) in [
            (Sensor::D405, [87.0, 58.0]),
            (Sensor::D415, [65.0, 40.0]),
            (Sensor::D455, [87.0, 58.0]),
            (Sensor::L515, [70.0, 55.0]),
            (Sensor::AzureKinect, [75.0, 65.0]),
            (Sensor::Gemini335, [90.0, 65.0]),
            (Sensor::Zivid2M60, [50.8, 41.9]),
            (Sensor::PhoxiS, [44.3, 33.9]),
            (Sensor::PhoxiM, [48.8, 37.5]),
        ] {
            let camera = sensor.intrinsics();
            let size = DVec2::new(camera.width() as f64, camera.height() as f64);
            let [first, last] = [DVec2::splat(-0.5), size - 0.5].map(|edge| camera.deproject(edge).unwrap());
            for axis in 0..2 {
                let angle = (last[axis].atan() - first[axis].atan()).to_degrees();
                assert!((angle - published[axis]).abs() < 0.05, "{sensor}: {angle} degrees");
            }
        }
    }

    /// A stereo camera searches 126 pixels of disparity (Intel), which determines its smallest depth.
    #[test]
    fn the_least_depth_of_realsense_follows_from_their_optics() {
        for sensor in [Sensor::D415, Sensor::D435, Sensor::D455] {
            let Principle::Stereo { baseline, focal, .. } = sensor.principle() else { panic!("{sensor}") };
            let (least, stated) = (focal * baseline / 126.0, sensor.depth_range().min);
            assert!((least / stated - 1.0).abs() < 0.07, "{sensor}: {least} m, stated {stated} m");
        }
    }

    /// RealSense L515: 2.5 mm at 1 m, 15.5 mm at 9 m. Azure Kinect: at most 17 mm.
    #[test]
    fn time_of_flight_has_the_published_noise() {
        let l515 = Sensor::L515.depth_error();
        assert!((l515.sigma(1.0) - 0.0025).abs() < 1e-9 && (l515.sigma(9.0) - 0.0155).abs() < 1e-9);
        assert!(Sensor::AzureKinect.depth_error().sigma(3.86) <= 0.017);
    }
}
