use super::file::{self, RecordPosition};
use super::messages::{AnyImage, Packing};
use crate::RecordingError;
use nextview::sensor::{ColorImage, DepthImage, Intrinsics};
use std::path::Path;

/// Position of an image in a file.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ImagePlace {
    pub place: RecordPosition,
    pub packing: Packing,
}

/// Reads the depth image of a message.
pub(crate) fn depth(
    path: &Path,
    at: ImagePlace,
    intrinsics: &Intrinsics,
) -> Result<DepthImage, RecordingError> {
    let message = file::message(path, at.place)?;
    AnyImage::read(&message, at.packing)?.1.depth(intrinsics)
}

/// Reads the colour image of a message.
pub(crate) fn color(
    path: &Path,
    at: ImagePlace,
    intrinsics: &Intrinsics,
) -> Result<ColorImage, RecordingError> {
    let message = file::message(path, at.place)?;
    AnyImage::read(&message, at.packing)?.1.color(intrinsics)
}
