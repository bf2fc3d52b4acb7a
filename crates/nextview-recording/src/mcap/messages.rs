//! The ROS 2 messages that are parsed.

use super::cdr::Cdr;
use crate::ros::{CameraInfo, CompressedImage, Image};
use crate::{RecordingError, rigid};
use glam::{DQuat, DVec3};
use nextview::geometry::Pose;
use nextview::sensor::{ColorImage, DepthImage, Intrinsics};

/// The header of a message.
pub(super) struct MessageHeader<'a> {
    /// Time of the content in seconds.
    pub time: f64,
    /// Name of the coordinate frame of the content or, for an image, of its camera.
    pub frame: &'a str,
}

impl<'a> MessageHeader<'a> {
    fn read(cdr: &mut Cdr<'a>) -> Result<Self, RecordingError> {
        let (seconds, nanoseconds) = (cdr.i32()?, cdr.u32()?);
        Ok(Self { time: seconds as f64 + 1e-9 * nanoseconds as f64, frame: cdr.text()? })
    }
}

/// Reads the optics of a camera from `sensor_msgs/msg/CameraInfo`.
pub(super) fn camera_info(message: &[u8]) -> Result<Intrinsics, RecordingError> {
    let mut cdr = Cdr::new(message)?;
    MessageHeader::read(&mut cdr)?;
    let (height, width) = (cdr.u32()?, cdr.u32()?);
    let (distortion_model, d) = (cdr.text()?, cdr.f64_list()?);
    CameraInfo { width, height, distortion_model, d: &d, k: cdr.f64s()? }.intrinsics()
}

/// Reads time and pose of the camera from `geometry_msgs/msg/PoseStamped`.
pub(super) fn pose_stamped(message: &[u8]) -> Result<(f64, Pose), RecordingError> {
    let mut cdr = Cdr::new(message)?;
    let time = MessageHeader::read(&mut cdr)?.time;
    let (position, rotation) = position_and_rotation(&mut cdr)?;
    Ok((time, rigid::from_quaternion(position, rotation).map_err(RecordingError::Content)?))
}

/// A transform of `tf2_msgs/msg/TFMessage`, unchanged.
pub(super) struct Transform<'a> {
    /// The header's frame is the parent.
    pub header: MessageHeader<'a>,
    pub child: &'a str,
    /// Takes points from child to parent; or the reason why it is invalid.
    pub parent_from_child: Result<Pose, nextview::Error>,
}

pub(super) fn transforms(message: &[u8]) -> Result<Vec<Transform<'_>>, RecordingError> {
    let mut cdr = Cdr::new(message)?;
    let length = cdr.u32()?;
    let mut transform = || {
        let (header, child) = (MessageHeader::read(&mut cdr)?, cdr.text()?);
        let (position, rotation) = position_and_rotation(&mut cdr)?;
        Ok(Transform { header, child, parent_from_child: Pose::new(rotation, position) })
    };
    // Lengths are not trusted for reserving memory: reading fails at the end of the message.
    (0..length).map(|_| transform()).collect()
}

fn position_and_rotation(cdr: &mut Cdr<'_>) -> Result<(DVec3, DQuat), RecordingError> {
    Ok((DVec3::from_array(cdr.f64s()?), DQuat::from_array(cdr.f64s()?)))
}

/// Encodings of images.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Packing {
    /// `sensor_msgs/msg/Image`.
    Plain,
    /// `sensor_msgs/msg/CompressedImage`.
    Compressed,
}

/// An image of either encoding, as in its message.
pub(super) enum AnyImage<'a> {
    Plain(Image<'a>),
    Compressed(CompressedImage<'a>),
}

impl<'a> AnyImage<'a> {
    pub fn read(message: &'a [u8], packing: Packing) -> Result<(MessageHeader<'a>, Self), RecordingError> {
        let mut cdr = Cdr::new(message)?;
        let header = MessageHeader::read(&mut cdr)?;
        let image = match packing {
            Packing::Plain => Self::Plain(Image {
                height: cdr.u32()?,
                width: cdr.u32()?,
                encoding: cdr.text()?,
                is_big_endian: cdr.u8()? != 0,
                step: cdr.u32()?,
                data: cdr.bytes()?,
            }),
            Packing::Compressed => {
                Self::Compressed(CompressedImage { format: cdr.text()?, data: cdr.bytes()? })
            }
        };
        Ok((header, image))
    }

    pub fn is_depth(&self) -> bool {
        match self {
            Self::Plain(image) => image.is_depth(),
            Self::Compressed(image) => image.is_depth(),
        }
    }

    pub fn depth(&self, intrinsics: &Intrinsics) -> Result<DepthImage, RecordingError> {
        match self {
            Self::Plain(image) => image.depth(intrinsics),
            Self::Compressed(image) => image.depth(intrinsics),
        }
    }

    pub fn color(&self, intrinsics: &Intrinsics) -> Result<ColorImage, RecordingError> {
        match self {
            Self::Plain(image) => image.color(intrinsics),
            Self::Compressed(image) => image.color(intrinsics),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec2;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn never_panics(order in 0..2_u8, bytes in prop::collection::vec(prop_oneof![Just(0), any::<u8>()], 0..600)) {
            let intrinsics = Intrinsics::pinhole(2, 2, DVec2::ONE, DVec2::splat(0.5)).unwrap();
            let message = [&[0, order, 0, 0], &bytes[..]].concat();
            let _ = camera_info(&message);
            let _ = pose_stamped(&message);
            let _ = transforms(&message).map(|transforms| transforms.len());
            for packing in [Packing::Plain, Packing::Compressed] {
                if let Ok((_, image)) = AnyImage::read(&message, packing) {
                    let _ = (image.is_depth(), image.depth(&intrinsics).is_ok(), image.color(&intrinsics).is_ok());
                }
            }
        }
    }
}
