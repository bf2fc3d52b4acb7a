//! What an entry of a journal holds.

use super::KeptFrame;
use nextview::geometry::Pose;
use nextview::sensor::{Depth, DepthImage, Frame, Intrinsics};
use serde::{Deserialize, Serialize};

/// Something to keep.
pub(super) enum Entry<'a> {
    /// A text.
    Heading(&'a str),
    /// A frame, and the number of the view that it was taken for.
    Frame(Option<usize>, &'a Frame),
}

/// What a frame is besides its image.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct About {
    view: Option<usize>,
    world_from_camera: Pose,
    range_m: f64,
    intrinsics: Intrinsics,
}

/// Ways to lay out entries that were never used may mean something else one day.
const VERSION: u8 = 1;

impl Entry<'_> {
    /// Its bytes. Of a frame: version, length of the JSON object that says all about it, that object, and the depth, compressed.
    pub fn to_bytes(&self) -> Vec<u8> {
        match self {
            Self::Heading(text) => [&[VERSION], text.as_bytes()].concat(),
            Self::Frame(view, frame) => {
                let about = About {
                    view: *view,
                    world_from_camera: frame.world_from_camera(),
                    range_m: frame.range(),
                    intrinsics: *frame.intrinsics(),
                };
                let about = serde_json::to_vec(&about).expect("numbers and names only");
                let length = (about.len() as u32).to_le_bytes();
                [&[VERSION], &length[..], &about, &compressed(frame.image())].concat()
            }
        }
    }
}

/// The text that these bytes hold.
pub(super) fn read_heading(bytes: &[u8]) -> Result<String, String> {
    let text = versioned(bytes)?;
    String::from_utf8(text.to_vec()).map_err(|error| format!("the heading is no text: {error}"))
}

/// The frame that these bytes hold.
pub(super) fn read_frame(bytes: &[u8]) -> Result<KeptFrame, String> {
    let rest = versioned(bytes)?;
    let cut = || "the entry ends within what describes the frame".to_owned();
    let (length, rest) = rest.split_at_checked(4).ok_or_else(cut)?;
    let length = u32::from_le_bytes(length.try_into().expect("four bytes"));
    let (about, depth) = rest.split_at_checked(length as usize).ok_or_else(cut)?;
    let about: About = serde_json::from_slice(about).map_err(|error| error.to_string())?;
    let pose = about.world_from_camera;
    // As it is, not as a new one, which would be normalised and so may differ by a bit.
    Pose::new(pose.rotation(), pose.translation()).map_err(|error| error.to_string())?;
    let image = decompressed(depth, &about.intrinsics)?;
    let frame =
        Frame::new(image, about.intrinsics, pose, about.range_m).map_err(|error| error.to_string())?;
    Ok(KeptFrame { view: about.view, frame })
}

fn versioned(bytes: &[u8]) -> Result<&[u8], String> {
    match bytes.split_first() {
        Some((&VERSION, rest)) => Ok(rest),
        Some((version, _)) => Err(format!("the entry is of version {version}, expected {VERSION}")),
        None => Err("the entry is empty".to_owned()),
    }
}

/// The depths as little-endian numbers, first the first byte of all, and so on: so laid out, what is alike lies together.
fn compressed(image: &DepthImage) -> Vec<u8> {
    let pixels = (0..image.height()).flat_map(|v| (0..image.width()).map(move |u| image.get(u, v)));
    let depths: Vec<[u8; 4]> = pixels.map(|pixel| metres(pixel).to_le_bytes()).collect();
    let planes: Vec<u8> = (0..4).flat_map(|i| depths.iter().map(move |depth| depth[i])).collect();
    lz4_flex::block::compress(&planes)
}

fn metres(pixel: Depth) -> f32 {
    match pixel {
        Depth::Missing => f32::NAN,
        Depth::Beyond => f32::INFINITY,
        Depth::Surface(depth) => depth,
    }
}

fn decompressed(bytes: &[u8], intrinsics: &Intrinsics) -> Result<DepthImage, String> {
    let n = intrinsics.n_pixels();
    // The format cannot hold more: without this, a few bytes could claim gigabytes.
    if n.saturating_mul(4) > bytes.len().saturating_mul(256).saturating_add(64) {
        return Err(format!("{} bytes cannot hold an image of {n} pixels", bytes.len()));
    }
    let mut planes = vec![0; 4 * n];
    let length = lz4_flex::block::decompress_into(bytes, &mut planes)
        .map_err(|error| format!("the image: {error}"))?;
    if length != planes.len() {
        return Err(format!("the image has {length} bytes, expected {}", planes.len()));
    }
    let depth = |i| f32::from_le_bytes([0, 1, 2, 3].map(|plane| planes[plane * n + i]));
    DepthImage::from_metres(intrinsics.width(), intrinsics.height(), (0..n).map(depth).collect())
        .map_err(|error| error.to_string())
}
