//! Small pictures of depth images, as PNG data URIs.

use super::color::{self, DEPTH, Rgb};
use crate::text;
use base64::prelude::{BASE64_STANDARD, Engine};
use nextview::sensor::{Depth, DepthImage};

const MAX_WIDTH: u32 = 160;
const MAX_HEIGHT: u32 = 120;

/// Entries of the palette: the ramp, then the three colours that are no depth.
const N_DEPTHS: usize = 253;
const BEYOND: u8 = 253;
const MISSING: u8 = 254;
const MISSING_STRIPE: u8 = 255;
const NO_DEPTH: [Rgb; 3] = [[255, 255, 255], [168, 173, 178], [96, 102, 108]];

/// The depths in metres that the colours span.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Range {
    near: f32,
    far: f32,
}

impl Range {
    /// The range of all images, without the lowest and the highest hundredth, in which single wrong pixels
    /// lie; none if no pixel shows a surface.
    pub fn of<'a>(images: impl IntoIterator<Item = &'a DepthImage>) -> Option<Self> {
        let mut depths = Vec::new();
        for image in images {
            depths.extend(shrink(image).surfaces());
        }
        depths.sort_by(f32::total_cmp);
        let last = depths.len().checked_sub(1)?;
        Some(Self { near: depths[last / 100], far: depths[last - last / 100] })
    }

    fn entry(&self, depth: f32) -> u8 {
        let width = (self.far - self.near).max(f32::MIN_POSITIVE);
        let t = ((depth - self.near) / width).clamp(0.0, 1.0);
        (t * (N_DEPTHS - 1) as f32).round() as u8
    }
}

/// The `img` element of view number `view`, counted from 1; empty for an image without pixels.
pub fn img(image: &DepthImage, range: Range, view: usize) -> String {
    let small = shrink(image);
    if small.pixels.is_empty() {
        return String::new();
    }
    let share = |n: usize| text::percent(n as f64 / small.pixels.len() as f64);
    let missing = small.pixels.iter().filter(|&&pixel| pixel == Depth::Missing).count();
    format!(
        r#"<img width="{}" height="{}" alt="Depth image of view {view}: {} surface, {} missing" src="data:image/png;base64,{}">"#,
        small.width,
        small.height,
        share(small.surfaces().count()),
        share(missing),
        BASE64_STANDARD.encode(small.png(range))
    )
}

/// The whole image as a PNG file in the same colours, from its nearest depth to its farthest.
pub fn depth_png(image: &DepthImage) -> Vec<u8> {
    let whole = sampled(image, 1);
    whole.png(Range::of([image]).unwrap_or_default())
}

/// The legend of the colours.
pub fn legend(range: Option<Range>) -> String {
    let scale = range.map_or_else(String::new, |Range { near, far }| {
        let stops = DEPTH.map(color::css).join(",");
        format!(
            r#"<span>{} <i class="scale" style="background:linear-gradient(90deg,{stops})"></i> {}</span>"#,
            text::metres(near as f64),
            text::metres(far as f64)
        )
    });
    let [beyond, missing, stripe] = NO_DEPTH.map(color::css);
    format!(
        r#"<p class="legend">Depth: {scale}<span><i class="box" style="background:{beyond}"></i> nothing in range</span><span><i class="box" style="background:repeating-linear-gradient(135deg,{missing} 0 3px,{stripe} 3px 5px)"></i> no measurement</span></p>"#
    )
}

struct Small {
    width: u32,
    height: u32,
    pixels: Vec<Depth>,
}

/// Takes single pixels: a mean over the edge of an object would show a depth that nobody measured.
fn shrink(image: &DepthImage) -> Small {
    let (width, height) = (image.width(), image.height());
    sampled(image, width.div_ceil(MAX_WIDTH).max(height.div_ceil(MAX_HEIGHT)).max(1))
}

/// Every so manieth pixel.
fn sampled(image: &DepthImage, step: u32) -> Small {
    let (width, height) = (image.width(), image.height());
    let samples = move |side: u32| (0..side.div_ceil(step)).map(move |i| (i * step + step / 2).min(side - 1));
    let pixels = samples(height).flat_map(|v| samples(width).map(move |u| image.get(u, v))).collect();
    Small { width: width.div_ceil(step), height: height.div_ceil(step), pixels }
}

impl Small {
    fn surfaces(&self) -> impl Iterator<Item = f32> {
        self.pixels.iter().filter_map(|pixel| match pixel {
            Depth::Surface(depth) => Some(*depth),
            _ => None,
        })
    }

    /// The entry of the palette for each pixel. Missing pixels are striped, so that they differ from depths
    /// in print.
    fn entries(&self, range: Range) -> Vec<u8> {
        let entry = |(i, pixel): (usize, &Depth)| match pixel {
            Depth::Surface(depth) => range.entry(*depth),
            Depth::Beyond => BEYOND,
            Depth::Missing => {
                let (u, v) = (i % self.width as usize, i / self.width as usize);
                if (u + v) % 5 < 2 { MISSING_STRIPE } else { MISSING }
            }
        };
        self.pixels.iter().enumerate().map(entry).collect()
    }

    fn png(&self, range: Range) -> Vec<u8> {
        let mut out = Vec::new();
        let mut encoder = png::Encoder::new(&mut out, self.width, self.height);
        encoder.set_color(png::ColorType::Indexed);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_palette(palette());
        let mut writer = encoder.write_header().expect("memory takes every byte");
        writer.write_image_data(&self.entries(range)).expect("one entry per pixel");
        writer.finish().expect("memory takes every byte");
        out
    }
}

fn palette() -> Vec<u8> {
    let depth = |i| color::color(&DEPTH, i as f64 / (N_DEPTHS - 1) as f64);
    (0..N_DEPTHS).map(depth).chain(NO_DEPTH).flatten().collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn image(width: u32, height: u32, depth: Vec<f32>) -> DepthImage {
        DepthImage::from_metres(width, height, depth).unwrap()
    }

    #[test]
    fn missing_beyond_and_depth_take_different_entries() {
        let image = image(4, 1, vec![1.0, 2.0, f32::INFINITY, f32::NAN]);
        let range = Range::of([&image]).unwrap();
        assert_eq!(range, Range { near: 1.0, far: 2.0 });
        let entries = shrink(&image).entries(range);
        assert_eq!(entries[..3], [0, 252, BEYOND]);
        assert!(entries[3] == MISSING || entries[3] == MISSING_STRIPE);
        assert_eq!(palette().len(), 3 * 256);
    }

    #[test]
    fn pictures_fit_and_keep_their_shape() {
        for (size, expected) in
            [((640, 480), (160, 120)), ((848, 480), (142, 80)), ((3, 2000), (1, 118)), ((5, 4), (5, 4))]
        {
            let (width, height) = size;
            let small = shrink(&image(width, height, vec![1.0; (width * height) as usize]));
            assert_eq!((small.width, small.height), expected);
            assert_eq!(small.pixels.len(), (small.width * small.height) as usize);
        }
    }

    #[test]
    fn a_png_reads_back() {
        let image = image(2, 1, vec![1.0, f32::INFINITY]);
        let png = shrink(&image).png(Range { near: 1.0, far: 1.0 });
        let mut decoder = png::Decoder::new(std::io::Cursor::new(png));
        decoder.set_transformations(png::Transformations::EXPAND);
        let mut reader = decoder.read_info().unwrap();
        let mut pixels = vec![0; 6];
        reader.next_frame(&mut pixels).unwrap();
        assert_eq!(pixels, [DEPTH[0], NO_DEPTH[0]].concat());
    }

    #[test]
    fn images_without_surface_or_without_pixels_are_fine() {
        let blank = image(2, 2, vec![f32::NAN; 4]);
        assert_eq!(Range::of([&blank]), None);
        assert!(img(&blank, Range::default(), 1).contains("100.0\u{202f}% missing"));
        assert_eq!(img(&image(0, 0, vec![]), Range::default(), 1), "");
    }
}
