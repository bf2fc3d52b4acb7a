use super::head::FrameHead;
use crate::refusal::Refusal;
use nextview::sensor::{DepthImage, Intrinsics};
use nextview_recording::{RecordingError, decode_color, decode_depth};
use nextview_scan::{Fault, LiveFrame};
use schemars::JsonSchema;
use serde::Deserialize;

/// A frame as received, not yet decoded: decoding is expensive and requires the camera.
pub(crate) struct PostedFrame {
    pub head: FrameHead,
    pub(super) depth: DepthBytes,
    pub(super) color: Option<Vec<u8>>,
    pub(super) mask: Option<Vec<u8>>,
}

/// A depth image as received.
pub(crate) enum DepthBytes {
    /// A PNG file.
    Png(Vec<u8>),
    /// Rows of little-endian numbers.
    Raw(ImageShape, Vec<u8>),
}

/// Size and data type of an image without a header.
#[derive(Clone, Copy)]
pub(crate) struct ImageShape {
    pub width: u32,
    pub height: u32,
    pub dtype: Dtype,
}

/// Data type of the pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub(crate) enum Dtype {
    /// 16-bit units of `depth_scale_m`; 0 is a missing pixel.
    U16,
    /// 32-bit metres; NaN is a missing pixel, infinity one without return.
    F32,
}

impl PostedFrame {
    /// A frame without colours and mask.
    pub fn of_depth(head: FrameHead, depth: DepthBytes) -> Self {
        Self { head, depth, color: None, mask: None }
    }

    /// Decodes the frame if it fits this camera. Images take no more memory than the camera's do.
    pub fn decode(&self, camera: &Intrinsics) -> Result<LiveFrame, Refusal> {
        let world_from_camera = self.head.pose(camera)?;
        let mask = self.mask.as_deref();
        let depth = match &self.depth {
            DepthBytes::Png(bytes) => {
                let image = decode_depth(bytes, mask, camera, self.head.depth_scale_m);
                image.map_err(|error| of_image("depth", &error))?
            }
            DepthBytes::Raw(shape, bytes) => raw(*shape, bytes, camera, self.head.depth_scale_m)?,
        };
        let color = self.color.as_ref().map(|bytes| decode_color(bytes, camera));
        let color = color.transpose().map_err(|error| of_image("color", &error))?;
        Ok(LiveFrame { depth, world_from_camera, color, name: self.head.id.clone() })
    }
}

fn of_image(key: &str, error: &RecordingError) -> Refusal {
    let fault = Fault::request(format!("`{key}`: {error}"));
    Refusal::content(Fault { key: Some(key.to_owned()), ..fault })
}

fn raw(shape: ImageShape, bytes: &[u8], camera: &Intrinsics, scale: f64) -> Result<DepthImage, Refusal> {
    let ImageShape { width, height, dtype } = shape;
    let (wanted, given) = ((camera.width(), camera.height()), (width, height));
    if given != wanted {
        let expected = format!("{} x {} pixels, as the camera has", wanted.0, wanted.1);
        return Err(Refusal::content(Fault::of_value("depth", format!("{width} x {height}"), expected)));
    }
    let per_pixel = if dtype == Dtype::U16 { 2 } else { 4 };
    let n_bytes = per_pixel * camera.n_pixels();
    if bytes.len() != n_bytes {
        let expected = format!("{n_bytes} bytes: {width} x {height} pixels of {per_pixel}");
        return Err(Refusal::content(Fault::of_value("depth", format!("{} bytes", bytes.len()), expected)));
    }
    let pixels = bytes.chunks_exact(per_pixel);
    let image = match dtype {
        Dtype::U16 => {
            let units: Vec<u16> = pixels.map(|pixel| u16::from_le_bytes([pixel[0], pixel[1]])).collect();
            DepthImage::from_units(width, height, &units, scale)
        }
        Dtype::F32 => {
            let metres = |pixel: &[u8]| f32::from_le_bytes([pixel[0], pixel[1], pixel[2], pixel[3]]);
            DepthImage::from_metres(width, height, pixels.map(metres).collect())
        }
    };
    image.map_err(|error| Refusal::content(Fault::from(error)))
}
