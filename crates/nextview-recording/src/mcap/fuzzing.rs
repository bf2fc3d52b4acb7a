//! Chunks and messages without a file, for `fuzz/` only.

use super::chunk;
use super::messages::{AnyImage, Packing, camera_info, pose_stamped, transforms};
use nextview::sensor::Intrinsics;

/// Unpacks the content of a chunk.
pub fn chunk(content: &[u8]) {
    let _ = chunk::records(content);
}

/// Reads a message as each of the types in recordings; images are those of this camera.
pub fn messages(message: &[u8], camera: &Intrinsics) {
    let _ = camera_info(message);
    let _ = pose_stamped(message);
    let _ = transforms(message);
    for packing in [Packing::Plain, Packing::Compressed] {
        if let Ok((_, image)) = AnyImage::read(message, packing) {
            let _ = (image.is_depth(), image.depth(camera), image.color(camera));
        }
    }
}
