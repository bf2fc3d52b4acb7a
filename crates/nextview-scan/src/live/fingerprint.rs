use nextview::geometry::Pose;
use nextview::sensor::{ColorImage, Depth, DepthImage};
use std::hash::{DefaultHasher, Hash, Hasher};

/// A hash of a camera's images and its stated pose: equal for equal bits, and almost never for others. It is
/// not cryptographic, and must not leave the process.
pub fn fingerprint(pose: Option<&Pose>, depth: &DepthImage, color: Option<&ColorImage>) -> u64 {
    let mut hasher = DefaultHasher::new();
    if let Some(pose) = pose {
        let (t, q) = (pose.translation().to_array(), pose.rotation().to_array());
        t.iter().chain(&q).for_each(|number| number.to_bits().hash(&mut hasher));
    }
    (depth.width(), depth.height()).hash(&mut hasher);
    for (u, v) in pixels(depth.width(), depth.height()) {
        // Missing pixels may have any non-number value.
        let bits = match depth.get(u, v) {
            Depth::Missing => f32::NAN.to_bits(),
            Depth::Beyond => f32::INFINITY.to_bits(),
            Depth::Surface(depth) => depth.to_bits(),
        };
        bits.hash(&mut hasher);
    }
    color.is_some().hash(&mut hasher);
    if let Some(color) = color {
        pixels(color.width(), color.height()).for_each(|(u, v)| color.get(u, v).hash(&mut hasher));
    }
    hasher.finish()
}

fn pixels(width: u32, height: u32) -> impl Iterator<Item = (u32, u32)> {
    (0..height).flat_map(move |v| (0..width).map(move |u| (u, v)))
}
