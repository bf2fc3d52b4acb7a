//! The evidence of one frame about the distance of a point to the surface.

use super::clear_depth::ClearDepth;
use super::depth_tiles::DepthTiles;
use glam::{DVec2, DVec3};
use nextview::geometry::Plane;
use nextview::sensor::{Depth, Frame, Intrinsics, Stretch};
use nextview::surface::TangentPlanes;
use nextview::{Cancel, Cancelled};

/// Distance along the ray over which a pixel's tangent plane represents the surface, in truncation distances.
/// It covers the whole truncation band of surfaces seen at 60 degrees; a longer plane would cut through
/// unseen parts.
const REACH: f64 = 2.0;

/// Weight of a silhouette, compared to 1 for a surface seen from the front. Its distance is only a lower
/// bound: with 0.5, a ball of 15 voxels is off by 0.016 voxels on average, with 0.05 by 0.007. Without it,
/// voxels near convex edges, which all frames see next to a silhouette, would be unmeasured or left to planes
/// extended too far.
const SILHOUETTE_WEIGHT: f32 = 0.1;

/// Largest half-width, pixels, of the window that must be clear around a free point.
const MAX_MARGIN: usize = 32;

/// The evidence of one frame about a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Evidence {
    /// Point and surroundings are free: a surface was measured behind them.
    Free,
    /// Point and surroundings are on rays without return. They may be free, or a surface without return, such
    /// as an object's rim behind a mask that is slightly too tight.
    Open,
    /// The surface is near: signed distance in metres, positive in front, and weight, 0..=1.
    Near { distance: f32, weight: f32 },
    /// A silhouette is near, next to a ray that ends farther away or, if `open`, has no return: a lower bound
    /// of the distance, and its weight.
    Silhouette { distance: f32, weight: f32, open: bool },
    /// The point lies behind a measured surface, beyond its reach.
    Hidden,
}

/// A frame prepared for queries about many points.
pub(super) struct FrameSurface {
    intrinsics: Intrinsics,
    planes: TangentPlanes,
    /// Whether each pixel is without return.
    is_open: Vec<bool>,
    clear_depth: ClearDepth,
    tiles: DepthTiles,
    /// Maximum stretch by the lens; `None` if unbounded.
    stretch: Option<Stretch>,
    /// In the camera frame.
    table_top: Option<Plane>,
    truncation: f64,
    margin: f64,
}

impl FrameSurface {
    /// Prepares a frame with distances truncated at `truncation` metres. Points count as free only without a
    /// surface within `margin` metres sideways. No point may be queried at depths below `nearest` metres.
    /// Points not above `table_top`, in world coordinates, end rays and are not surface.
    pub(super) fn new(
        frame: &Frame,
        table_top: Option<Plane>,
        truncation: f64,
        margin: f64,
        nearest: f64,
        cancel: &Cancel,
    ) -> Result<Self, Cancelled> {
        let (intrinsics, planes) = (*frame.intrinsics(), TangentPlanes::new(frame));
        let (depth, width) = (free_depth(frame), intrinsics.width() as usize);
        let is_open: Vec<bool> = frame.image().pixels().map(|depth| depth == Depth::Beyond).collect();
        let tiles = DepthTiles::new(&depth, &is_open, width);
        let stretch = intrinsics.stretch();
        let half_width = margin_in_pixels(&intrinsics, margin, nearest);
        let clear_depth = ClearDepth::new(depth, width, half_width, cancel)?;
        let table_top = table_top.map(|top| top.moved(&frame.world_from_camera().inverse()));
        Ok(Self { intrinsics, planes, is_open, clear_depth, tiles, stretch, table_top, truncation, margin })
    }

    /// Returns the frame's evidence about points of the camera frame; `None` outside the image, without a
    /// measurement, and behind the surface. It takes several points at a time, since undoing the lens is most
    /// of the work.
    pub(super) fn evidence<const N: usize>(&self, points: &[DVec3; N]) -> [Option<Evidence>; N] {
        let pixels = self.intrinsics.project_lanes(points);
        std::array::from_fn(|i| self.evidence_at(points[i], pixels[i]?))
    }

    /// Returns the evidence about all points of a ball of the camera frame if the pixels that may show it
    /// agree; `None` if they may not.
    pub(super) fn evidence_of_ball(&self, center: DVec3, radius: f64) -> Option<Evidence> {
        let (nearest, farthest) = (center.z - radius, center.z + radius);
        if nearest <= 0.0 {
            return None;
        }
        let ideal = center.truncate() / center.z;
        // |x / z - x_c / z_c| = |(x - x_c) z_c - x_c (z - z_c)| / (z z_c)
        let spread = radius * (1.0 + ideal.length()) / nearest;
        let stretch = self.stretch.filter(|stretch| ideal.length() + spread <= stretch.radius)?;
        let shown = self.intrinsics.project(center)?;
        // One more, since points are looked up at the nearest pixel.
        let half_width = spread * stretch.factor * self.intrinsics.focal().max_element() + 1.0;
        let (low, high) = (shown - half_width, shown + half_width);
        if !(self.intrinsics.contains(low) && self.intrinsics.contains(high)) {
            return None;
        }
        let margin = margin_in_pixels(&self.intrinsics, self.margin, nearest);
        let range = |low: f64, high: f64| {
            (low.max(0.0) as usize).saturating_sub(margin)..=high.max(0.0) as usize + margin
        };
        let extent = self.tiles.extent(range(low.x, high.x), range(low.y, high.y));
        if farthest + self.truncation < extent.least as f64 {
            return match (extent.all_open, extent.any_open) {
                (true, _) => Some(Evidence::Open),
                (_, false) => Some(Evidence::Free),
                _ => None,
            };
        }
        let is_hidden = extent.least > 0.0 && nearest > extent.most as f64 + REACH * self.truncation;
        is_hidden.then_some(Evidence::Hidden)
    }

    /// Returns the evidence of the pixel nearest to `shown`, the image of the point.
    fn evidence_at(&self, point: DVec3, shown: DVec2) -> Option<Evidence> {
        let pixel = self.pixel(shown)?;
        let wanted =
            margin_in_pixels(&self.intrinsics, self.margin, point.z).min(self.clear_depth.max_half_width());
        if self.is_clear(point, pixel, wanted) {
            return Some(if self.is_open[pixel] { Evidence::Open } else { Evidence::Free });
        }
        self.near_plane(point, pixel)
            .or_else(|| self.near_silhouette(point, pixel, wanted))
            .or_else(|| self.hidden(point, pixel))
    }

    fn hidden(&self, point: DVec3, pixel: usize) -> Option<Evidence> {
        let depth = self.clear_depth.around(pixel, 0) as f64;
        (depth > 0.0 && point.z > depth + self.truncation).then_some(Evidence::Hidden)
    }

    /// Whether the rays of all pixels at most `n_pixels` away continue behind the point.
    fn is_clear(&self, point: DVec3, pixel: usize, n_pixels: usize) -> bool {
        point.z + self.truncation < self.clear_depth.around(pixel, n_pixels) as f64
    }

    fn near_plane(&self, point: DVec3, pixel: usize) -> Option<Evidence> {
        let shown = self.planes.point(pixel)?.as_dvec3();
        let is_table = || self.table_top.is_some_and(|top| top.height(shown) <= 0.0);
        if (point.z - shown.z).abs() > REACH * self.truncation || is_table() {
            return None;
        }
        let plane = self.planes.at(pixel)?;
        let distance = plane.normal.as_dvec3().dot(point) - plane.offset as f64;
        if distance.abs() >= self.truncation {
            return None;
        }
        // Behind the surface the evidence weakens: the other side of a thin part may be there.
        let confidence = (1.0 + distance / self.truncation).min(1.0).powi(2) as f32;
        Some(Evidence::Near { distance: distance as f32, weight: plane.cosine * confidence })
    }

    /// Returns the evidence of a ray that passes close to the surface: the silhouette's sideways distance is
    /// a lower bound.
    fn near_silhouette(&self, point: DVec3, pixel: usize, wanted: usize) -> Option<Evidence> {
        let n_pixels = (0..wanted).take_while(|&n| self.is_clear(point, pixel, n)).last()?;
        let distance = ((n_pixels as f64 + 0.5) * point.z / self.intrinsics.focal().max_element()) as f32;
        Some(Evidence::Silhouette { distance, weight: SILHOUETTE_WEIGHT, open: self.is_open[pixel] })
    }

    /// Returns the index of the pixel nearest to an image position; `None` outside the image.
    fn pixel(&self, shown: DVec2) -> Option<usize> {
        self.intrinsics.contains(shown).then_some(())?;
        // Rounds half up, as `contains` does; at the border, the sum may round up once more.
        let [u, v] = (shown + 0.5).to_array().map(|x| x as usize);
        let [width, height] = [self.intrinsics.width(), self.intrinsics.height()].map(|n| n as usize);
        Some(v.min(height - 1) * width + u.min(width - 1))
    }
}

/// Returns the number of pixels in `margin` metres at this depth.
fn margin_in_pixels(intrinsics: &Intrinsics, margin: f64, depth: f64) -> usize {
    // Half a pixel more, since a point is looked up at the nearest pixel.
    let pixels = margin / depth * intrinsics.focal().max_element() + 0.5;
    (pixels.ceil() as usize).min(MAX_MARGIN)
}

/// Returns the depth up to which each pixel is free; 0 if it was not measured.
fn free_depth(frame: &Frame) -> Vec<f32> {
    let depth = |depth: Depth| match depth {
        Depth::Missing => 0.0,
        Depth::Beyond => frame.range() as f32,
        Depth::Surface(depth) => depth,
    };
    frame.image().pixels().map(depth).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    use crate::synthetic_frames::of_depth as frame;
    use nextview::geometry::{Pose, random::Random};
    use nextview::sensor::Distortion;

    #[test]
    fn the_distance_to_a_slanted_wall_is_exact() {
        // The plane x + 2 z = 1.
        let frame = frame(21, 17, |u, _| (1.0 / ((u as f64 - 10.0) / 50.0 + 2.0)) as f32);
        let surface = FrameSurface::new(&frame, None, 0.05, 0.01, 0.4, &Cancel::default()).unwrap();
        for point in
            [DVec3::new(0.013, 0.02, 0.5), DVec3::new(-0.05, -0.01, 0.54), DVec3::new(0.0, 0.0, 0.46)]
        {
            let expected = (1.0 - point.x - 2.0 * point.z) / 5.0_f64.sqrt();
            let Some(Evidence::Near { distance, weight }) = surface.evidence(&[point])[0] else {
                panic!("{point}")
            };
            assert!((distance as f64 - expected).abs() < 1e-6, "{distance} {expected}");
            assert!((0.0..=1.0).contains(&weight));
        }
        assert_eq!(surface.evidence(&[DVec3::new(0.0, 0.0, 0.4)])[0], Some(Evidence::Free));
        assert_eq!(surface.evidence(&[DVec3::new(0.0, 0.0, 0.6)])[0], Some(Evidence::Hidden));
        for x in [0.5, -0.5, 1e300] {
            assert_eq!(surface.evidence(&[DVec3::new(x, 0.0, 0.5)])[0], None, "outside the image");
        }
    }

    #[test]
    fn beside_a_silhouette_the_distance_is_the_one_to_it() {
        // A surface in the left half, nothing in the right.
        let frame = frame(21, 17, |u, _| if u < 10 { 0.5 } else { f32::INFINITY });
        let surface = FrameSurface::new(&frame, None, 0.02, 0.04, 0.5, &Cancel::default()).unwrap();
        let at = |x: f64| surface.evidence(&[DVec3::new(x, 0.0, 0.5)])[0];
        // A pixel is 1 cm wide there.
        for (x, expected) in [(0.0, 0.005), (0.01, 0.015), (0.02, 0.025)] {
            let Some(Evidence::Silhouette { distance, open: true, .. }) = at(x) else { panic!("{x}") };
            assert!((distance - expected).abs() < 1e-6, "{x}: {distance}");
        }
        assert_eq!(at(0.06), Some(Evidence::Open));
    }

    /// The slow twin: every point by itself.
    #[test]
    fn what_holds_for_a_ball_holds_for_all_of_its_points() {
        let mut random = Random::new(5, 0);
        let mut n_found = [0; 3];
        let none = Distortion::None;
        let barrel = Distortion::BrownConrady([-0.15, 0.02, 0.001, -0.002, 0.0]);
        let folded = Distortion::BrownConrady([-2.0, 0.0, 0.0, 0.0, 0.0]);
        for lens in [none, barrel, Intrinsics::d435i().distortion(), folded] {
            // A slanted surface with a step and a hole, and nothing next to it.
            let depth = |u: u32, v: u32| match (u, v) {
                (60.., _) => f32::INFINITY,
                (20..24, 30..33) => 0.0,
                (30.., _) => 0.5 + v as f32 * 1e-3,
                _ => 0.6 - v as f32 * 1e-3,
            };
            let plain = frame(96, 64, depth);
            let camera = Intrinsics::pinhole(96, 64, DVec2::splat(100.0), DVec2::new(47.5, 31.5)).unwrap();
            let camera = camera.with_distortion(lens).unwrap();
            let frame = Frame::new(plain.image().clone(), camera, Pose::IDENTITY, plain.range()).unwrap();
            let surface = FrameSurface::new(&frame, None, 0.02, 0.01, 0.1, &Cancel::default()).unwrap();
            for _ in 0..10_000 {
                let center = random.in_cube() * DVec3::new(0.7, 0.5, 0.35) + DVec3::new(0.0, 0.0, 0.5);
                let radius = 0.02 * random.unit();
                let Some(of_all) = surface.evidence_of_ball(center, radius) else { continue };
                n_found[match of_all {
                    Evidence::Free => 0,
                    Evidence::Open => 1,
                    Evidence::Hidden => 2,
                    _ => panic!("{of_all:?}"),
                }] += 1;
                let points: [DVec3; 16] =
                    std::array::from_fn(|_| center + random.in_cube().normalize_or_zero() * radius);
                assert_eq!(surface.evidence(&points), [Some(of_all); 16], "{center} {radius} {lens:?}");
            }
        }
        assert!(n_found.iter().all(|n| *n > 100), "{n_found:?}");
    }
}
