//! The ROS 2 messages that are read: `sensor_msgs/msg/CameraInfo`, `sensor_msgs/msg/Image`,
//! `geometry_msgs/msg/PoseStamped`.

use super::cdr::Cdr;
use crate::depth_png::check_size;
use crate::{RecordingError, lens, rigid};
use glam::{DQuat, DVec2, DVec3};
use nextview::geometry::Pose;
use nextview::sensor::{DepthImage, Distortion, Intrinsics};

/// When the content was taken, seconds; and the name of its frame, which is skipped.
fn stamp(cdr: &mut Cdr<'_>) -> Result<f64, RecordingError> {
    let (seconds, nanoseconds) = (cdr.i32()?, cdr.u32()?);
    cdr.text()?;
    Ok(seconds as f64 + 1e-9 * nanoseconds as f64)
}

/// The optics of a camera.
pub(super) fn camera_info(message: &[u8]) -> Result<Intrinsics, RecordingError> {
    let mut cdr = Cdr::new(message)?;
    stamp(&mut cdr)?;
    let (height, width) = (cdr.u32()?, cdr.u32()?);
    let distortion = distortion(cdr.text()?, &cdr.f64_list()?)?;
    let [fx, _, cx, _, fy, cy, ..]: [f64; 9] = cdr.f64s()?;
    let intrinsics = Intrinsics::pinhole(width, height, DVec2::new(fx, fy), DVec2::new(cx, cy))?;
    lens::checked(intrinsics.with_distortion(distortion)?)
}

/// Most coefficients of a distortion that OpenCV knows.
const MAX_COEFFICIENTS: usize = 14;

/// Distortion by ROS's name for it (REP 104).
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

/// Where the camera was, and when.
pub(super) fn pose_stamped(message: &[u8]) -> Result<(f64, Pose), RecordingError> {
    let mut cdr = Cdr::new(message)?;
    let time = stamp(&mut cdr)?;
    let (position, rotation) = (DVec3::from_array(cdr.f64s()?), DQuat::from_array(cdr.f64s()?));
    Ok((time, rigid::from_quaternion(position, rotation).map_err(RecordingError::Content)?))
}

/// An image as it is in its message.
pub(super) struct Image<'a> {
    pub time: f64,
    width: u32,
    height: u32,
    pub encoding: &'a str,
    is_big_endian: bool,
    /// Bytes from row to row.
    step: u32,
    data: &'a [u8],
}

impl<'a> Image<'a> {
    pub fn new(message: &'a [u8]) -> Result<Self, RecordingError> {
        let mut cdr = Cdr::new(message)?;
        Ok(Self {
            time: stamp(&mut cdr)?,
            height: cdr.u32()?,
            width: cdr.u32()?,
            encoding: cdr.text()?,
            is_big_endian: cdr.u8()? != 0,
            step: cdr.u32()?,
            data: cdr.bytes()?,
        })
    }

    /// Whether its pixels are depths (REP 118): millimetres in 16 bits or metres in 32.
    pub fn is_depth(&self) -> bool {
        matches!(self.encoding, "16UC1" | "32FC1")
    }

    /// The depth. Of depths in metres, those that are infinite are missing, since that says only that they
    /// are beyond an unknown range.
    pub fn depth(&self, intrinsics: &Intrinsics) -> Result<DepthImage, RecordingError> {
        check_size(self.width, self.height, intrinsics)?;
        if self.encoding == "16UC1" {
            let units: Vec<u16> = self.pixels()?.map(u16::from_le_bytes).collect();
            return Ok(DepthImage::from_units(self.width, self.height, &units, 0.001)?);
        }
        let metres = self.pixels()?.map(f32::from_le_bytes);
        let metres = metres.map(|depth| if depth.is_finite() { depth } else { f32::NAN });
        Ok(DepthImage::from_metres(self.width, self.height, metres.collect())?)
    }

    /// The bytes of the pixels, each with its lowest byte first.
    fn pixels<const N: usize>(&self) -> Result<impl Iterator<Item = [u8; N]>, RecordingError> {
        let (row, step) = (N * self.width as usize, self.step as usize);
        let needed = step * (self.height as usize - 1) + row;
        if step < row || self.data.len() < needed {
            return Err(RecordingError::Content(format!(
                "the image has {} bytes in rows of {step}, expected {} rows of at least {row} bytes",
                self.data.len(),
                self.height
            )));
        }
        let rows = self.data.chunks(step).take(self.height as usize);
        let pixels = rows.flat_map(move |bytes| bytes[..row].as_chunks::<N>().0);
        Ok(pixels.map(|pixel| {
            let mut pixel = *pixel;
            if self.is_big_endian {
                pixel.reverse();
            }
            pixel
        }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn image<'a>(encoding: &'a str, is_big_endian: bool, step: u32, data: &'a [u8]) -> Image<'a> {
        Image { time: 0.0, width: 2, height: 2, encoding, is_big_endian, step, data }
    }

    fn intrinsics() -> Intrinsics {
        Intrinsics::pinhole(2, 2, DVec2::ONE, DVec2::splat(0.5)).unwrap()
    }

    #[test]
    fn rows_may_be_padded_and_bytes_in_either_order() {
        let expected = DepthImage::from_units(2, 2, &[1, 2, 256, 0], 0.001).unwrap();
        let same = |image: Image<'_>| {
            format!("{:?}", image.depth(&intrinsics()).unwrap()) == format!("{expected:?}")
        };
        assert!(same(image("16UC1", false, 4, &[1, 0, 2, 0, 0, 1, 0, 0])));
        assert!(same(image("16UC1", true, 5, &[0, 1, 0, 2, 9, 1, 0, 0, 0])));
        let metres = [0.001_f32, 0.002, 0.256, f32::INFINITY];
        let little: Vec<u8> = metres.iter().flat_map(|m| m.to_le_bytes()).collect();
        let big: Vec<u8> = metres.iter().flat_map(|m| m.to_be_bytes()).collect();
        assert!(same(image("32FC1", false, 8, &little)) && same(image("32FC1", true, 8, &big)));
    }

    #[test]
    fn images_that_are_too_short_are_refused() {
        for (step, n) in [(3, 8), (4, 7), (5, 8), (u32::MAX, 8)] {
            let error =
                image("16UC1", false, step, &vec![0; n]).depth(&intrinsics()).unwrap_err().to_string();
            assert!(error.contains("expected 2 rows of at least 4 bytes"), "{error}");
        }
    }

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

    proptest! {
        #[test]
        fn never_panics(order in 0..2_u8, bytes in prop::collection::vec(prop_oneof![Just(0), any::<u8>()], 0..600)) {
            let message = [&[0, order, 0, 0], &bytes[..]].concat();
            let _ = camera_info(&message);
            let _ = pose_stamped(&message);
            let _ = Image::new(&message).map(|image| image.depth(&intrinsics()).is_ok());
        }
    }
}
