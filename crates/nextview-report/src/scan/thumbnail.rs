//! Small pictures of depth images, as PNG data URIs.

use super::color::{self, DEPTH, Rgb};
use super::png_file::png_file;
use crate::text;
use base64::prelude::{BASE64_STANDARD, Engine};
use nextview::sensor::{ColorImage, Depth, DepthImage};

/// Maximum width and height of a picture, pixels.
pub type Size = [u32; 2];

/// The size in the table.
pub const SMALL: Size = [160, 120];

/// Twice that, for an enlarged view.
const LARGE: Size = [320, 240];

/// Maximum number of views with large pictures, which keeps the page below 3 MB.
const MOST_LARGE: usize = 30;

/// Number of depth entries of the palette: the ramp, followed by the three colours that are not depths.
const N_DEPTHS: usize = 253;
const BEYOND: u8 = 253;
const MISSING: u8 = 254;
const MISSING_STRIPE: u8 = 255;
const NO_DEPTH: [Rgb; 3] = [[255, 255, 255], [168, 173, 178], [96, 102, 108]];

/// The depths in metres spanned by the colours.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Range {
    near: f32,
    far: f32,
}

impl Range {
    /// Returns the range of all images without the lowest and the highest hundredth, which contain single
    /// wrong pixels; `None` if no pixel shows a surface.
    pub fn of<'a>(images: impl IntoIterator<Item = &'a DepthImage>) -> Option<Self> {
        let mut depths = Vec::new();
        for image in images {
            depths.extend(shrink(image, SMALL).surfaces());
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

/// Returns the size of depth images on a page with this number of views.
pub fn depth_size(n_views: usize) -> Size {
    if n_views <= MOST_LARGE { LARGE } else { SMALL }
}

/// Returns the `img` element of a depth image of view number `view`, counted from 1; empty for an image
/// without pixels.
pub fn depth(image: &DepthImage, range: Range, view: usize, size: Size) -> String {
    let small = shrink(image, size);
    if small.pixels.is_empty() {
        return String::new();
    }
    let share = |n: usize| text::percent(n as f64 / small.pixels.len() as f64);
    let missing = small.pixels.iter().filter(|&&pixel| pixel == Depth::Missing).count();
    let alt = format!(
        "Depth image of view {view}: {} surface, {} missing",
        share(small.surfaces().count()),
        share(missing)
    );
    img(small.width, small.height, ("depth", &alt), &small.png(range))
}

/// Returns the whole image as a PNG file in the same colours. They span the depths of another image, such as
/// the first of a scan, which makes pictures comparable.
pub fn depth_png(image: &DepthImage, first: &DepthImage) -> Vec<u8> {
    shrink(image, [u32::MAX; 2]).png(Range::of([first]).unwrap_or_default())
}

/// Returns the `img` element of a colour image of view number `view`.
pub fn color(image: &ColorImage, view: usize) -> String {
    let (step, [width, height]) = step(image.width(), image.height(), SMALL);
    let pixel = |i: u32| image.get((i % width) * step, (i / width) * step);
    // The lower bits are noise, and take half of the bytes.
    let bytes: Vec<u8> = (0..width * height).flat_map(pixel).map(|c| c & 0xF8 | c >> 5).collect();
    if bytes.is_empty() {
        return String::new();
    }
    let png = png_file([width, height], &bytes, None, png::Compression::High);
    img(width, height, ("color", &format!("Colour image of view {view}")), &png)
}

/// A picture of some kind in a button that enlarges it.
fn img(width: u32, height: u32, (kind, alt): (&str, &str), png: &[u8]) -> String {
    format!(
        r#"<button type="button" class="enlarge"><img width="{width}" height="{height}" data-kind="{kind}" alt="{alt}" src="data:image/png;base64,{}"></button>"#,
        BASE64_STANDARD.encode(png)
    )
}

/// Returns the legend of the colours.
pub fn legend(range: Option<Range>) -> String {
    let scale = range.map_or_else(String::new, |Range { near, far }| {
        let stop = |(i, color)| format!(r#"<stop offset="{}" stop-color="{}"/>"#, i as f64 / 3.0, color::css(color));
        let stops: String = DEPTH.into_iter().enumerate().map(stop).collect();
        format!(
            r##"<span>{} <svg class="scale" viewBox="0 0 10 1" preserveAspectRatio="none" aria-hidden="true"><linearGradient id="depths">{stops}</linearGradient><path fill="url(#depths)" d="M0 0h10v1H0z"/></svg> {}</span>"##,
            text::metres(near as f64),
            text::metres(far as f64)
        )
    });
    let [beyond, missing, stripe] = NO_DEPTH.map(color::css);
    let filled =
        |paths: &str| format!(r#"<svg class="box" viewBox="0 0 22 11" aria-hidden="true">{paths}</svg>"#);
    format!(
        r#"<p class="legend">Depth: {scale}<span>{} nothing in range</span><span>{} no measurement</span></p>"#,
        filled(&format!(r#"<path fill="{beyond}" d="M0 0h22v11H0z"/>"#)),
        filled(&format!(
            r#"<path fill="{missing}" d="M0 0h22v11H0z"/><path stroke="{stripe}" stroke-width="2" d="M0 6l6-6M0 12l12-12M6 12l12-12M12 12l12-12M18 12l6-6"/>"#
        ))
    )
}

struct Small {
    width: u32,
    height: u32,
    pixels: Vec<Depth>,
}

/// Takes single pixels: a mean across the edge of an object would show a depth that was not measured.
fn shrink(image: &DepthImage, size: Size) -> Small {
    let (step, [width, height]) = step(image.width(), image.height(), size);
    let at = |i: u32, side: u32| (i * step + step / 2).min(side - 1);
    let pixel = |i: u32| image.get(at(i % width, image.width()), at(i / width, image.height()));
    Small { width, height, pixels: (0..width * height).map(pixel).collect() }
}

/// The step between the pixels taken to make an image fit, and its resulting size.
fn step(width: u32, height: u32, [max_width, max_height]: Size) -> (u32, Size) {
    let step = width.div_ceil(max_width).max(height.div_ceil(max_height)).max(1);
    (step, [width.div_ceil(step), height.div_ceil(step)])
}

impl Small {
    fn surfaces(&self) -> impl Iterator<Item = f32> {
        self.pixels.iter().filter_map(|pixel| match pixel {
            Depth::Surface(depth) => Some(*depth),
            _ => None,
        })
    }

    /// The palette entry of each pixel. Missing pixels are striped, to differ from depths in print.
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
        let size = [self.width, self.height];
        png_file(size, &self.entries(range), Some(palette()), png::Compression::High)
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
        let entries = shrink(&image, SMALL).entries(range);
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
            let small = shrink(&image(width, height, vec![1.0; (width * height) as usize]), SMALL);
            assert_eq!((small.width, small.height), expected);
            assert_eq!(small.pixels.len(), (small.width * small.height) as usize);
        }
    }

    #[test]
    fn a_png_reads_back() {
        let image = image(2, 1, vec![1.0, f32::INFINITY]);
        let png = shrink(&image, SMALL).png(Range { near: 1.0, far: 1.0 });
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
        assert!(depth(&blank, Range::default(), 1, SMALL).contains("100.0\u{202f}% missing"));
        assert_eq!(depth(&image(0, 0, vec![]), Range::default(), 1, SMALL), "");
    }
}
