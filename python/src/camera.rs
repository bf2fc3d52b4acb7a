//! Optics and range of a depth camera.

use crate::errors::exception;
use crate::values::numbers;
use glam::DVec2;
use nextview::sensor::{DepthRange, Distortion, Intrinsics, Sensor};
use nextview_scan::Fault;
use pyo3::prelude::*;

/// Base class of `nextview.Camera`.
#[pyclass(frozen, subclass, module = "nextview._native")]
pub struct Camera {
    /// The optics.
    pub intrinsics: Intrinsics,
    /// The depths that it measures, in metres.
    pub depth_range: DepthRange,
}

#[pymethods]
impl Camera {
    #[new]
    #[pyo3(signature = (width, height, fx, fy, cx, cy, distortion, distortion_model, depth_range_m))]
    #[expect(clippy::too_many_arguments, reason = "the numbers of a calibration")]
    fn new(
        py: Python<'_>,
        width: u32,
        height: u32,
        fx: f64,
        fy: f64,
        cx: f64,
        cy: f64,
        distortion: &Bound<'_, PyAny>,
        distortion_model: &str,
        depth_range_m: &Bound<'_, PyAny>,
    ) -> PyResult<Self> {
        let coefficients = "at most 5 numbers, k1, k2, p1, p2, k3";
        let distortion = numbers("distortion", distortion, |shape| matches!(shape, [0..=5]), coefficients)?;
        let range = "the least and the largest depth, metres";
        let depth_range = numbers("depth_range_m", depth_range_m, |shape| shape == [2], range)?;
        let make = || -> Result<Self, Fault> {
            let distortion = distortion_of(&distortion, distortion_model)?;
            let pinhole = Intrinsics::pinhole(width, height, DVec2::new(fx, fy), DVec2::new(cx, cy))?;
            let depth_range = DepthRange { min: depth_range[0], max: depth_range[1] };
            depth_range.check().map_err(|error| Fault::from(error).within("`depth_range_m`"))?;
            Ok(Self { intrinsics: pinhole.with_distortion(distortion)?, depth_range })
        };
        make().map_err(|fault| exception(py, fault))
    }

    /// The numbers of a sensor by name, in the order of the constructor.
    #[staticmethod]
    fn of_sensor(py: Python<'_>, name: &str) -> PyResult<Numbers> {
        let sensor: Sensor =
            name.parse().map_err(|error: nextview::Error| exception(py, Fault::from(error)))?;
        Ok(numbers_of(&sensor.intrinsics(), sensor.depth_range()))
    }

    /// The numbers of this camera, in the order of the constructor.
    fn numbers(&self) -> Numbers {
        numbers_of(&self.intrinsics, self.depth_range)
    }
}

/// Width, height, fx, fy, cx, cy, distortion, its model, depth range.
type Numbers = (u32, u32, f64, f64, f64, f64, Vec<f64>, &'static str, (f64, f64));

/// The numbers of optics and range.
pub fn numbers_of(intrinsics: &Intrinsics, range: DepthRange) -> Numbers {
    let (focal, center) = (intrinsics.focal(), intrinsics.center());
    let (coefficients, model) = match intrinsics.distortion() {
        Distortion::None => (Vec::new(), "none"),
        Distortion::BrownConrady(k) => (k.to_vec(), "brown-conrady"),
        Distortion::InverseBrownConrady(k) => (k.to_vec(), "inverse-brown-conrady"),
    };
    let size = (intrinsics.width(), intrinsics.height());
    let range = (range.min, range.max);
    (size.0, size.1, focal.x, focal.y, center.x, center.y, coefficients, model, range)
}

fn distortion_of(coefficients: &[f64], model: &str) -> Result<Distortion, Fault> {
    let mut k = [0.0; 5];
    k[..coefficients.len()].copy_from_slice(coefficients);
    match model {
        "none" if coefficients.is_empty() => Ok(Distortion::None),
        "brown-conrady" if coefficients.is_empty() => Ok(Distortion::None),
        "brown-conrady" => Ok(Distortion::BrownConrady(k)),
        "inverse-brown-conrady" => Ok(Distortion::InverseBrownConrady(k)),
        _ => {
            let expected = "brown-conrady or inverse-brown-conrady, or none if there are no coefficients";
            Err(Fault::of_value("distortion_model", model, expected))
        }
    }
}
