use super::file::{self, Place};
use super::messages::Image;
use crate::RecordingError;
use nextview::sensor::{DepthImage, Intrinsics};
use std::path::Path;

/// Reads the depth image of a message.
pub(crate) fn depth(
    path: &Path,
    place: Place,
    intrinsics: &Intrinsics,
) -> Result<DepthImage, RecordingError> {
    let message = file::message(path, place)?;
    Image::new(&message)?.depth(intrinsics)
}
