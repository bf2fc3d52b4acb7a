use super::head::{FrameHead, millimetre};
use super::posted::{Dtype, ImageShape};
use crate::refusal::Refusal;
use nextview_scan::Fault;
use schemars::JsonSchema;
use serde::Deserialize;

/// The head of a frame in the query, if the body is only an image.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct FrameQuery {
    /// A name unique among the frames of the scan. Required except to locate an image.
    id: Option<String>,
    /// Pose of the camera: the 16 numbers of the matrix by rows, separated by commas. `None` to locate the
    /// frame, which requires `registration.given_poses` = tracked.
    world_from_camera: Option<String>,
    /// Metres per unit of 16-bit depth. Default 0.001.
    depth_scale_m: Option<f64>,
    /// For raw numbers, the width in pixels.
    width: Option<u32>,
    /// For raw numbers, the height in pixels.
    height: Option<u32>,
    /// For raw numbers, their type.
    dtype: Option<Dtype>,
}

impl FrameQuery {
    pub fn head(&self) -> Result<FrameHead, Refusal> {
        Ok(FrameHead {
            id: self.id.clone(),
            world_from_camera: self.world_from_camera.as_deref().map(rows).transpose()?,
            depth_scale_m: self.depth_scale_m.unwrap_or_else(millimetre),
            camera: None,
        })
    }

    pub fn shape(&self) -> Result<ImageShape, Refusal> {
        Ok(ImageShape {
            width: self.width.ok_or_else(|| missing("width", "a number of pixels"))?,
            height: self.height.ok_or_else(|| missing("height", "a number of pixels"))?,
            dtype: self.dtype.ok_or_else(|| missing("dtype", "u16 or f32"))?,
        })
    }
}

fn missing(key: &str, expected: &str) -> Refusal {
    Refusal::content(Fault::of_value(key, "missing in the query", expected))
}

fn rows(text: &str) -> Result<[[f64; 4]; 4], Refusal> {
    let numbers: Option<Vec<f64>> = text.split(',').map(|number| number.trim().parse().ok()).collect();
    let numbers = numbers.and_then(|numbers| <[f64; 16]>::try_from(numbers).ok()).ok_or_else(|| {
        let text: String = text.chars().take(300).collect();
        Refusal::content(Fault::of_value(
            "world_from_camera",
            text,
            "16 numbers with commas between them, by rows",
        ))
    })?;
    Ok(std::array::from_fn(|i| std::array::from_fn(|j| numbers[4 * i + j])))
}
