use super::chunk::{Chunk, LANES, larger, smaller};
use super::pixel_box::PixelBox;
use super::polynomial::Polynomial;
use glam::DVec2;
use nextview::sensor::{Distortion, Intrinsics};

/// Finds the pixels near a point of the ideal plane z = 1 without the lens model, which is slow to invert and
/// does not have an answer everywhere.
///
/// The image position of a point is that of an ideal pinhole camera plus, for a real lens, a polynomial. The
/// error is known because every sample was tested, so no sample is ever missed.
pub(super) struct PixelLocator {
    focal: DVec2,
    center: DVec2,
    /// Width and height of the image in pixels.
    size: DVec2,
    bend: Option<Bend>,
    /// Upper bound on the position error of a sample, pixels.
    error: f64,
}

/// The deviation of the lens from a pinhole camera's position.
struct Bend {
    /// Maps the box around all samples to the square -1..1. A point outside gets the value of the nearest
    /// point inside.
    middle: DVec2,
    half: DVec2,
    per_half: DVec2,
    pixels: Polynomial,
}

impl PixelLocator {
    /// Slack in pixels that covers the rounding of a position.
    const SLACK: f64 = 1e-6;

    /// Points for the fit: many more than terms.
    const N_FIT: usize = 4000;

    /// Creates a locator for these samples, given as pixel and ideal point; `None` if there is no sample.
    pub fn new(intrinsics: &Intrinsics, samples: &[(DVec2, DVec2)]) -> Option<Self> {
        let first = samples.first()?.1;
        let (low, high) = samples.iter().fold((first, first), |(l, h), (_, s)| (l.min(*s), h.max(*s)));
        let size = DVec2::new(intrinsics.width() as f64, intrinsics.height() as f64);
        let (focal, center) = (intrinsics.focal(), intrinsics.center());
        let mut locator = Self { focal, center, size, bend: None, error: 0.0 };
        if intrinsics.distortion() != Distortion::None {
            let (middle, half) = (0.5 * (low + high), (0.5 * (high - low)).max(1.0 / focal));
            let per_half = 1.0 / half;
            let some = samples.iter().step_by(samples.len().div_ceil(Self::N_FIT));
            let pairs =
                some.map(|&(pixel, ideal)| ((ideal - middle) * per_half, pixel - locator.position(ideal)));
            let bend = Bend { middle, half, per_half, pixels: Polynomial::fit(pairs) };
            // Extreme lenses overflow; their deviation from the pinhole camera then counts as error.
            locator.bend = Some(bend).filter(|bend| bend.pixels.steepest().is_finite());
        }
        let error_of =
            |&(pixel, ideal): &(DVec2, DVec2)| (locator.position(ideal) - pixel).abs().max_element();
        let error = samples.iter().map(error_of).fold(0.0, f64::max);
        Some(Self { error, ..locator })
    }

    /// Returns the margin for [`boxes_of`](Self::boxes_of), in pixels, with which the joined boxes of a
    /// triangle's corners hold every sample inside the triangle. The triangle's extent along both axes must
    /// be at most `extent`, in the ideal plane, and `reach` at least the [`reach`](Self::reach) of each
    /// corner.
    pub fn margin(&self, extent: f64, reach: f64) -> f64 {
        let bending = self.bend.as_ref().map_or(0.0, |bend| {
            let step = (extent / bend.half.min_element()).min(2.0);
            let by_slope = step * bend.pixels.steepest();
            // A sample is a mean of the corners, and the polynomial nearly that of its values at the corners.
            let by_bend = step * step * bend.pixels.most_bent();
            if reach <= 1.0 { by_slope.min(by_bend) } else { by_slope }
        });
        bending + self.error + Self::SLACK
    }

    /// Raises `reach` to the extent of the points, which is at most 1 within the box around all samples.
    #[inline(always)]
    pub fn reach(&self, x: &Chunk, y: &Chunk, reach: &mut Chunk) {
        if let Some(bend) = &self.bend {
            for i in 0..LANES {
                let point = bend.to_square(DVec2::new(x[i], y[i]));
                reach[i] = larger(reach[i], larger(point.x.abs(), point.y.abs()));
            }
        }
    }

    /// Returns a bound on the coordinates of points with this [`reach`](Self::reach).
    pub fn farthest(&self, reach: f64) -> f64 {
        self.bend.as_ref().map_or(f64::INFINITY, |b| (b.middle.abs() + reach * b.half).max_element())
    }

    /// Returns the pixels whose samples may have the same x or y as a point, or are less than the margin
    /// away.
    #[inline(always)]
    pub fn boxes_of(&self, x: &Chunk, y: &Chunk, margin: f64) -> [PixelBox; LANES] {
        let [mut first_u, mut first_v, mut end_u, mut end_v] = [[0; LANES]; 4];
        for i in 0..LANES {
            let position = self.position(DVec2::new(x[i], y[i]));
            let (first, end) = (position + (0.5 - margin), position + (0.5 + margin));
            (first_u[i], first_v[i]) = (rounded(first.x, self.size.x), rounded(first.y, self.size.y));
            (end_u[i], end_v[i]) = (rounded(end.x, self.size.x), rounded(end.y, self.size.y));
        }
        std::array::from_fn(|i| PixelBox::new([first_u[i], first_v[i]], [end_u[i], end_v[i]]))
    }

    /// Position of a point in the image, pixels.
    #[inline(always)]
    fn position(&self, ideal: DVec2) -> DVec2 {
        let pinhole = ideal * self.focal + self.center;
        match &self.bend {
            Some(bend) => pinhole + bend.at(ideal),
            None => pinhole,
        }
    }
}

impl Bend {
    #[inline(always)]
    fn to_square(&self, ideal: DVec2) -> DVec2 {
        (ideal - self.middle) * self.per_half
    }

    #[inline(always)]
    fn at(&self, ideal: DVec2) -> DVec2 {
        let DVec2 { x, y } = self.to_square(ideal);
        let inside = |value| larger(-1.0, smaller(1.0, value));
        self.pixels.at(DVec2::new(inside(x), inside(y)))
    }
}

/// The whole number nearest to a value, from 0 to `limit`, read from the last bits of the value plus 2^52.
/// This takes fewer instructions than a cast, which handles NaN, and than `floor`.
#[inline(always)]
fn rounded(value: f64, limit: f64) -> i32 {
    let clamped = larger(smaller(value, limit), 0.0);
    (clamped + (1_u64 << 52) as f64).to_bits() as i32
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::samples::ImageSamples;
    use nextview::geometry::random::Random;

    fn pinhole(width: u32, height: u32) -> Intrinsics {
        Intrinsics::pinhole(width, height, DVec2::new(610.0, 590.0), DVec2::new(31.3, 20.9)).unwrap()
    }

    fn box_around(locator: &PixelLocator, corners: [DVec2; 3]) -> PixelBox {
        let x: Chunk = std::array::from_fn(|i| corners[i % 3].x);
        let y: Chunk = std::array::from_fn(|i| corners[i % 3].y);
        let mut reach = [0.0; LANES];
        locator.reach(&x, &y, &mut reach);
        let reach = reach.into_iter().fold(0.0, f64::max);
        assert!(corners.iter().all(|c| c.abs().max_element() <= locator.farthest(reach) + 1e-12));
        let [a, b, c] = corners;
        let extent =
            [a - b, b - c, c - a].map(|edge| edge.abs().max_element()).into_iter().fold(0.0, f64::max);
        locator
            .boxes_of(&x, &y, locator.margin(extent, reach))
            .into_iter()
            .fold(PixelBox::NOTHING, PixelBox::join)
    }

    #[test]
    fn no_sample_lies_between_pixels() {
        let camera = pinhole(64, 48);
        let samples = ImageSamples::new(&camera).unwrap();
        let at = |u: f64, v: f64| {
            let point = camera.deproject(DVec2::new(u, v)).unwrap();
            box_around(samples.locator(), [point; 3])
        };
        assert_eq!(at(10.0, 20.0), PixelBox::new([10, 20], [11, 21]));
        assert!(at(10.3, 20.7).is_empty());
        assert!(at(-9.0, 99.0).is_empty(), "beyond the border");
        let lens = ImageSamples::new(&Intrinsics::d435i()).unwrap();
        let margin = lens.locator().margin(1e-3, 1.0);
        assert!(margin < 0.15, "the polynomial fits the lens only within {margin} pixels");
    }

    /// The brute-force reference checks all samples.
    #[test]
    fn a_box_holds_every_sample_in_a_triangle() {
        let strong = Distortion::BrownConrady([-0.2, 0.05, 0.01, -0.01, 0.0]);
        let folding = Distortion::BrownConrady([-2.0, 0.0, 0.0, 0.0, 0.0]);
        let wide = Intrinsics::pinhole(64, 48, DVec2::splat(40.0), DVec2::new(30.0, 25.0)).unwrap();
        let line = pinhole(1, 9).with_distortion(strong).unwrap();
        let [strong, folding] = [strong, folding].map(|lens| wide.with_distortion(lens).unwrap());
        let mut random = Random::new(1, 0);
        for camera in [pinhole(64, 48), pinhole(1, 1), line, Intrinsics::d435i(), strong, folding] {
            let samples = ImageSamples::new(&camera).unwrap();
            let (x, y) = (samples.x().as_flattened(), samples.y().as_flattened());
            let points: Vec<DVec2> = x.iter().zip(y).map(|(&x, &y)| DVec2::new(x, y)).collect();
            let width = samples.chunks_in_row() * LANES;
            for _ in 0..100 {
                let (center, size) = (0.7 * random.in_cube().truncate(), random.range(0.0, 1.0).powi(3));
                let corners = [0; 3].map(|_| center + size * random.in_cube().truncate());
                let pixels = box_around(samples.locator(), corners);
                for (i, _) in points.iter().enumerate().filter(|(_, point)| inside(**point, corners)) {
                    let is_held =
                        pixels.columns().contains(&(i % width)) && pixels.rows().contains(&(i / width));
                    assert!(is_held, "sample {i} in {corners:?} is outside {pixels:?}");
                }
            }
        }
    }

    fn inside(point: DVec2, [a, b, c]: [DVec2; 3]) -> bool {
        let (a, b, c) = (a - point, b - point, c - point);
        let sides = [a.perp_dot(b), b.perp_dot(c), c.perp_dot(a)];
        sides.iter().all(|&side| side >= 0.0) || sides.iter().all(|&side| side <= 0.0)
    }
}
