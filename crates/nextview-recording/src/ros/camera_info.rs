use crate::{RecordingError, lens};
use glam::DVec2;
use nextview::sensor::{Distortion, Intrinsics};

/// The optics of a camera, as in `sensor_msgs/msg/CameraInfo`.
#[derive(Clone, Copy, Debug)]
pub struct CameraInfo<'a> {
    /// Number of columns.
    pub width: u32,
    /// Number of rows.
    pub height: u32,
    /// ROS name of the distortion model (REP 104).
    pub distortion_model: &'a str,
    /// Distortion coefficients; k1, k2, p1, p2, k3 for `plumb_bob`.
    pub d: &'a [f64],
    /// The camera matrix by rows in pixels; 0, 0 is the centre of the first pixel.
    pub k: [f64; 9],
}

/// Maximum number of distortion coefficients in OpenCV.
const MAX_COEFFICIENTS: usize = 14;

impl CameraInfo<'_> {
    /// Converts to intrinsics.
    ///
    /// # Errors
    /// If they cannot be those of a camera, or the distortion model is unknown.
    pub fn intrinsics(&self) -> Result<Intrinsics, RecordingError> {
        let [fx, _, cx, _, fy, cy, ..] = self.k;
        let intrinsics =
            Intrinsics::pinhole(self.width, self.height, DVec2::new(fx, fy), DVec2::new(cx, cy))?;
        lens::checked(intrinsics.with_distortion(distortion(self.distortion_model, self.d)?)?)
    }
}

fn distortion(model: &str, coefficients: &[f64]) -> Result<Distortion, RecordingError> {
    let five: [f64; 5] = std::array::from_fn(|i| coefficients.get(i).copied().unwrap_or(0.0));
    if coefficients.len() > MAX_COEFFICIENTS {
        let problem = format!(
            "the distortion has {} coefficients, expected at most {MAX_COEFFICIENTS}",
            coefficients.len()
        );
        return Err(RecordingError::Content(problem));
    }
    let is_polynomial = coefficients.iter().skip(5).all(|k| *k == 0.0);
    match model {
        _ if coefficients.iter().all(|k| *k == 0.0) => Ok(Distortion::None),
        "plumb_bob" | "rational_polynomial" if is_polynomial => Ok(Distortion::BrownConrady(five)),
        _ => Err(RecordingError::Content(format!(
            "the distortion is '{model}' with the coefficients {coefficients:?}, expected plumb_bob with k1, k2, p1, p2, k3"
        ))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distortion_is_known_or_none() {
        assert_eq!(distortion("", &[]).unwrap(), Distortion::None);
        assert_eq!(distortion("equidistant", &[0.0; 4]).unwrap(), Distortion::None);
        let k = [0.1, -0.2, 0.01, 0.02, 0.3];
        assert_eq!(distortion("plumb_bob", &k).unwrap(), Distortion::BrownConrady(k));
        let eight = [&k[..], &[0.0; 3]].concat();
        assert_eq!(distortion("rational_polynomial", &eight).unwrap(), Distortion::BrownConrady(k));
        for (model, k) in [("equidistant", vec![0.1]), ("rational_polynomial", vec![0.1; 8])] {
            assert!(distortion(model, &k).unwrap_err().to_string().contains("expected plumb_bob"));
        }
    }
}
