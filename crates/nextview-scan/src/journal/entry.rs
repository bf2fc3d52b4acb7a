//! The content of a journal's entries.

use super::kept::{JournalEntry, KeptFrame, SkippedView};
use nextview::geometry::Pose;
use nextview::sensor::{ColorImage, DepthImage, Frame, Intrinsics};
use serde::{Deserialize, Serialize};

/// An entry to write.
pub(super) enum Entry<'a> {
    /// A text.
    Heading(&'a str),
    /// A frame.
    Frame(&'a KeptFrame),
    /// A view that must not be proposed again.
    Skip(&'a SkippedView),
}

/// A JSON object at the head of an entry.
#[derive(Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum Head {
    /// A frame without its image, which follows.
    Frame(FrameEntry),
    /// A view that must not be proposed again.
    Skip(SkippedView),
}

/// A frame without its image.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct FrameEntry {
    view: Option<usize>,
    was_asked: bool,
    world_from_camera: Pose,
    range_m: f64,
    intrinsics: Intrinsics,
    /// Length of the depth in bytes, if colours follow it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    depth_bytes: Option<usize>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    name: Option<String>,
}

/// Version of the layout of entries.
const VERSION: u8 = 2;

impl Entry<'_> {
    /// The bytes of the entry. For a frame: version, length of the head, head, and compressed depth and
    /// colours.
    pub fn to_bytes(&self) -> Vec<u8> {
        match self {
            Self::Heading(text) => [&[VERSION], text.as_bytes()].concat(),
            Self::Skip(skipped) => with_head(&Head::Skip((*skipped).clone()), &[]),
            Self::Frame(KeptFrame { view, was_asked, frame, color, name }) => {
                let mut images = compressed(frame.image());
                let depth_bytes = color.as_ref().map(|_| images.len());
                images.extend(color.iter().flat_map(compressed_color));
                let about = FrameEntry {
                    view: *view,
                    was_asked: *was_asked,
                    depth_bytes,
                    name: name.clone(),
                    world_from_camera: frame.world_from_camera(),
                    range_m: frame.range(),
                    intrinsics: *frame.intrinsics(),
                };
                with_head(&Head::Frame(about), &images)
            }
        }
    }
}

fn with_head(head: &Head, rest: &[u8]) -> Vec<u8> {
    let head = serde_json::to_vec(head).expect("numbers and names only");
    let length = (head.len() as u32).to_le_bytes();
    [&[VERSION], &length[..], &head, rest].concat()
}

/// The text in these bytes.
pub(super) fn read_heading(bytes: &[u8]) -> Result<String, String> {
    let text = versioned(bytes)?;
    String::from_utf8(text.to_vec()).map_err(|error| format!("the heading is not text: {error}"))
}

/// The frame or the skipped view in these bytes.
pub(super) fn read_entry(bytes: &[u8]) -> Result<JournalEntry, String> {
    let rest = versioned(bytes)?;
    let cut = || "the entry ends within its header".to_owned();
    let (length, rest) = rest.split_at_checked(4).ok_or_else(cut)?;
    let length = u32::from_le_bytes(length.try_into().expect("four bytes"));
    let (head, images) = rest.split_at_checked(length as usize).ok_or_else(cut)?;
    match serde_json::from_slice(head).map_err(|error| error.to_string())? {
        Head::Skip(skipped) => Ok(JournalEntry::Skip(skipped)),
        Head::Frame(about) => {
            let FrameEntry { view, was_asked, world_from_camera, range_m, intrinsics, depth_bytes, name } =
                about;
            let cut = || "the entry ends within its depth".to_owned();
            let (depth, color) = match depth_bytes {
                Some(length) => images.split_at_checked(length).map(|(a, b)| (a, Some(b))).ok_or_else(cut)?,
                None => (images, None),
            };
            let image = decompressed(depth, &intrinsics)?;
            let color = color.map(|color| decompressed_color(color, &intrinsics)).transpose()?;
            let frame = Frame::new(image, intrinsics, world_from_camera, range_m);
            let frame = frame.map_err(|error| error.to_string())?;
            Ok(JournalEntry::Frame(Box::new(KeptFrame { view, was_asked, frame, color, name })))
        }
    }
}

fn versioned(bytes: &[u8]) -> Result<&[u8], String> {
    match bytes.split_first() {
        Some((&VERSION, rest)) => Ok(rest),
        Some((version, _)) => Err(format!("the entry is of version {version}, expected {VERSION}")),
        None => Err("the entry is empty".to_owned()),
    }
}

/// The depths as little-endian numbers, the first byte of all pixels first, and so on: similar bytes are
/// adjacent.
fn compressed(image: &DepthImage) -> Vec<u8> {
    let depths: Vec<[u8; 4]> = image.pixels().map(|pixel| pixel.metres().to_le_bytes()).collect();
    let planes: Vec<u8> = (0..4).flat_map(|i| depths.iter().map(move |depth| depth[i])).collect();
    lz4_flex::block::compress(&planes)
}

/// The red, green and blue of all pixels.
fn compressed_color(image: &ColorImage) -> Vec<u8> {
    lz4_flex::block::compress(&image.pixels().flatten().collect::<Vec<u8>>())
}

fn decompressed(bytes: &[u8], intrinsics: &Intrinsics) -> Result<DepthImage, String> {
    let n = intrinsics.n_pixels();
    let planes = unpacked(bytes, 4, n)?;
    let depth = |i| f32::from_le_bytes([0, 1, 2, 3].map(|plane| planes[plane * n + i]));
    DepthImage::from_metres(intrinsics.width(), intrinsics.height(), (0..n).map(depth).collect())
        .map_err(|error| error.to_string())
}

fn decompressed_color(bytes: &[u8], intrinsics: &Intrinsics) -> Result<ColorImage, String> {
    let bytes = unpacked(bytes, 3, intrinsics.n_pixels())?;
    let pixels = bytes.chunks_exact(3).map(|pixel| [pixel[0], pixel[1], pixel[2]]).collect();
    ColorImage::new(intrinsics.width(), intrinsics.height(), pixels).map_err(|error| error.to_string())
}

/// The bytes of an image with this number of bytes per pixel.
fn unpacked(bytes: &[u8], per_pixel: usize, n: usize) -> Result<Vec<u8>, String> {
    // The format's maximum: without this check, a few bytes could claim gigabytes.
    if n.saturating_mul(per_pixel) > bytes.len().saturating_mul(256).saturating_add(64) {
        return Err(format!("{} bytes cannot hold an image of {n} pixels", bytes.len()));
    }
    let mut image = vec![0; per_pixel * n];
    let length =
        lz4_flex::block::decompress_into(bytes, &mut image).map_err(|error| format!("the image: {error}"))?;
    match length == image.len() {
        true => Ok(image),
        false => Err(format!("the image has {length} bytes, expected {}", image.len())),
    }
}
