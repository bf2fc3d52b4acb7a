use crate::RecordingError;
use crate::color_file;
use crate::depth_png;
use crate::mcap::{self, ImagePlace};
use nextview::geometry::Pose;
use nextview::sensor::{ColorImage, Depth, DepthImage, Frame, Intrinsics};
use std::path::PathBuf;

/// A recorded measurement of a depth camera. Its image stays in its file until [loaded](Self::load).
#[derive(Debug)]
pub struct RecordedFrame {
    /// A readable name: `frame 12`, the name of its file, or the number and topic of its message.
    pub name: String,
    /// Time of the measurement in seconds; `None` if not recorded.
    pub timestamp_s: Option<f64>,
    /// Pose of the camera: rigid, at most 100 m from the origin.
    pub world_from_camera: Pose,
    pub(crate) intrinsics: Intrinsics,
    pub(crate) depth: DepthSource,
    pub(crate) color: Option<ColorSource>,
}

/// The source of a frame's depth.
#[derive(Debug)]
pub(crate) enum DepthSource {
    /// In a PNG file with units of this many metres; pixels masked with 0 show nothing of the object.
    Png { path: PathBuf, unit: f64, mask: Option<PathBuf> },
    /// In a message of an MCAP file.
    Message { path: PathBuf, at: ImagePlace },
}

/// The source of a frame's colour image.
#[derive(Debug)]
pub(crate) enum ColorSource {
    /// In a PNG or JPEG file.
    File(PathBuf),
    /// In a message of an MCAP file.
    Message { path: PathBuf, at: ImagePlace },
}

/// A frame requires a depth up to which pixels without return are free. Recorded images have such pixels only
/// outside their masks: no recording states that a ray met no surface, and a missing pixel means nothing.
const RANGE: f64 = 10.0;

impl RecordedFrame {
    /// Loads the image. All images are checked when the recording is opened, so this fails only if a file has
    /// changed.
    pub fn load(&self) -> Result<Frame, RecordingError> {
        let image = match &self.depth {
            DepthSource::Png { path, unit, mask } => {
                depth_png::read(path, &self.intrinsics, *unit, mask.as_deref())?
            }
            DepthSource::Message { path, at } => {
                let image = mcap::depth(path, *at, &self.intrinsics);
                image.map_err(|error| RecordingError::format(&self.name, error.to_string()).in_file(path))?
            }
        };
        Ok(Frame::new(image, self.intrinsics, self.world_from_camera, RANGE)?)
    }

    /// Approximate memory for loading, in bytes.
    pub(crate) fn cost(&self) -> usize {
        let record = match &self.depth {
            DepthSource::Png { .. } => 0,
            DepthSource::Message { at, .. } => 3 * at.place.n_bytes,
        };
        16 * self.intrinsics.n_pixels() + record
    }

    /// Size of the file with the image in bytes; `None` if the file holds many.
    pub(crate) fn file_size(&self) -> std::io::Result<Option<u64>> {
        match &self.depth {
            DepthSource::Png { path, .. } => Ok(Some(path.metadata()?.len())),
            DepthSource::Message { .. } => Ok(None),
        }
    }

    /// Whether the frame has a colour image.
    pub fn has_color(&self) -> bool {
        self.color.is_some()
    }

    /// Loads the colour image, of the size of the depth image; `None` if there is none. As with the depth,
    /// this fails only if a file has changed since the recording was opened.
    pub fn load_color(&self) -> Result<Option<ColorImage>, RecordingError> {
        let color = match &self.color {
            None => return Ok(None),
            Some(ColorSource::File(path)) => color_file::read(path, &self.intrinsics),
            Some(ColorSource::Message { path, at }) => {
                let named = |error: RecordingError| {
                    RecordingError::format(format!("the colour of {}", self.name), error.to_string())
                };
                mcap::color(path, *at, &self.intrinsics).map_err(|error| named(error).in_file(path))
            }
        };
        color.map(Some)
    }
}

/// The reason why an image is useless; `None` if it shows something.
pub(crate) fn uselessness(image: &DepthImage) -> Option<String> {
    let mut pixels = image.pixels().peekable();
    let first = *pixels.peek()?;
    if pixels.any(|pixel| pixel != first) {
        return None;
    }
    Some(match first {
        Depth::Surface(depth) => format!("every pixel has the depth {depth} m"),
        // Pixels are free only outside masks.
        Depth::Beyond => "the mask covers no pixel with a depth".to_owned(),
        Depth::Missing => "no pixel has a depth".to_owned(),
    })
}
