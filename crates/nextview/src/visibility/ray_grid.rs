use crate::geometry::lanes::LANES;
use crate::geometry::{Aabb, Pose};
use crate::sensor::{Distortion, Intrinsics, Points};
use glam::{DVec2, DVec3};
use std::f64::consts::FRAC_PI_2;

/// The ray spacing at which no voxel of the box is missed: 1 / sqrt(2) of a voxel. A voxel contains a ball as
/// wide as its edge, whose image holds a disc as wide as the voxel at its depth. A square grid hits every
/// disc whose diameter is sqrt(2) of its spacing.
pub const NO_VOXEL_MISSED: f64 = std::f64::consts::FRAC_1_SQRT_2;

/// The planning rays of a view on the image: a square grid over the part of the image that shows the box.
#[derive(Clone, Debug)]
pub struct RayGrid {
    intrinsics: Intrinsics,
    /// Maximum length on the plane z = 1 covered by a step of one pixel, along x and y.
    pixel_on_plane: f64,
    /// Maximum angle between a ray through the image and the optical axis, radians.
    widest: f64,
}

/// Maximum number of rays of a view: 2048 x 2048.
const MOST_RAYS: f64 = (1 << 22) as f64;

/// Equal cells of an image with a ray through the middle of each, row by row.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cells {
    /// Corner of the first cell, and size of each, in pixels.
    low: DVec2,
    size: DVec2,
    columns: usize,
    rows: usize,
}

impl Cells {
    pub fn len(&self) -> usize {
        self.columns * self.rows
    }

    #[inline(always)]
    fn middle(&self, column: usize, row: usize) -> DVec2 {
        self.low + self.size * DVec2::new(column as f64 + 0.5, row as f64 + 0.5)
    }
}

impl RayGrid {
    /// Creates the grid rule of a camera.
    pub fn new(intrinsics: &Intrinsics) -> Self {
        let (pixel_on_plane, widest) = (largest_pixel(intrinsics), widest_angle(intrinsics));
        Self { intrinsics: *intrinsics, pixel_on_plane, widest }
    }

    /// Returns the directions, in the camera frame and with z = 1, of a view's rays towards the box. Their
    /// distance at the far side of the box is at most `spacing` metres. None reaches a box behind the camera.
    ///
    /// If there were more than 2^22, they are farther apart, or left out if the box is outside the image.
    pub fn directions(
        &self,
        world_from_camera: &Pose,
        aabb: &Aabb,
        spacing: f64,
    ) -> impl Iterator<Item = DVec3> + '_ {
        let cells = self.cells(world_from_camera, aabb, spacing);
        let places = (0..cells.rows).flat_map(move |row| (0..cells.columns).map(move |column| (column, row)));
        let ideal = move |(column, row)| self.intrinsics.deproject(cells.middle(column, row));
        places.filter_map(ideal).map(|ideal| ideal.extend(1.0))
    }

    /// The cells of the image with these rays.
    pub(super) fn cells(&self, world_from_camera: &Pose, aabb: &Aabb, spacing: f64) -> Cells {
        let camera_from_world = world_from_camera.inverse();
        let corners = aabb.corners().map(|corner| camera_from_world.transform_point(corner));
        let farthest = corners.iter().map(|corner| corner.z).fold(0.0, f64::max);
        let step = spacing / (farthest.max(f64::MIN_POSITIVE) * self.pixel_on_plane);
        let (low, high) = if farthest > 0.0 { self.window(&corners) } else { (DVec2::ZERO, DVec2::ZERO) };
        let n = ((high - low) / step).ceil().max(DVec2::ZERO);
        let n = match n.element_product() {
            // With an infinite number of rows, the product is not a number.
            _ if n.min_element() == 0.0 => DVec2::ZERO,
            product if product > MOST_RAYS => self.bounded(n, &corners),
            _ => n,
        };
        Cells { low, size: (high - low) / n.max(DVec2::ONE), columns: n.x as usize, rows: n.y as usize }
    }

    /// Columns and rows within the maximum number of rays; none if the box is outside the image. For a box
    /// far outside, the whole image is searched, with rays as close as the box is small.
    fn bounded(&self, n: DVec2, corners: &[DVec3; 8]) -> DVec2 {
        if !self.may_show(corners) {
            return DVec2::ZERO;
        }
        // Keeps the ratio of columns to rows, except for a single row.
        let scale = (MOST_RAYS / n.x / n.y).sqrt();
        let [columns, rows] = (n * scale).floor().max(DVec2::ONE).to_array();
        let columns = columns.min(MOST_RAYS);
        DVec2::new(columns, rows.min((MOST_RAYS / columns).floor()))
    }

    /// Whether the ball around the corners (camera frame) reaches into the cone around the image.
    fn may_show(&self, corners: &[DVec3; 8]) -> bool {
        let middle = corners.iter().sum::<DVec3>() / 8.0;
        let radius = middle.distance(corners[0]);
        if middle.length() <= radius {
            return true;
        }
        middle.angle_between(DVec3::Z) <= self.widest + (radius / middle.length()).asin()
    }

    /// The positions on the plane z = 1 of the rays through the cells from `start` on, which is one of them:
    /// the twin of [`directions`](Self::directions) for several rays.
    #[inline(always)]
    pub(super) fn ideal(&self, cells: &Cells, start: usize) -> Points<LANES> {
        let mut pixels = Points { x: [0.0; LANES], y: [0.0; LANES], is_known: [false; LANES] };
        let (mut column, mut row) = (start % cells.columns, start / cells.columns);
        for lane in 0..LANES {
            let pixel = cells.middle(column, row);
            (pixels.x[lane], pixels.y[lane], pixels.is_known[lane]) = (pixel.x, pixel.y, row < cells.rows);
            column += 1;
            if column == cells.columns {
                (column, row) = (0, row + 1);
            }
        }
        self.intrinsics.deproject_lanes(pixels)
    }

    /// The part of the image, in pixels, that can show the box with these corners (camera frame).
    fn window(&self, corners: &[DVec3; 8]) -> (DVec2, DVec2) {
        let border_low = DVec2::splat(-0.5);
        let border_high = DVec2::new(self.intrinsics.width() as f64, self.intrinsics.height() as f64) - 0.5;
        // A corner without an image (behind the camera or far outside) requires a search of the whole image.
        let (mut low, mut high) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
        for pixel in self.intrinsics.project_lanes(corners) {
            let Some(pixel) = pixel else { return (border_low, border_high) };
            (low, high) = (low.min(pixel), high.max(pixel));
        }
        // A lens bends the box's edges between the corners; a margin of 2 % of its image covers that.
        let bend = if self.intrinsics.distortion() == Distortion::None { 0.0 } else { 0.02 };
        let margin = (high - low) * bend;
        ((low - margin).max(border_low), (high + margin).min(border_high))
    }
}

/// The maximum angle between the optical axis and a ray through a mesh of 17 x 17 points of the image,
/// borders included, and a hundredth more; pi / 2 if one has no ray.
fn widest_angle(intrinsics: &Intrinsics) -> f64 {
    let size = DVec2::new(intrinsics.width() as f64, intrinsics.height() as f64);
    let places = (0..17).flat_map(|i| (0..17).map(move |j| DVec2::new(i as f64, j as f64) / 16.0));
    let angle = |place: DVec2| match intrinsics.deproject(size * place - 0.5) {
        Some(ideal) => ideal.extend(1.0).angle_between(DVec3::Z),
        None => FRAC_PI_2,
    };
    (places.map(angle).fold(0.0, f64::max) * 1.01).min(FRAC_PI_2)
}

/// The maximum length of a pixel step on the plane z = 1, over a mesh of the image. A lens changes it
/// smoothly by a few per cent, so a mesh of 17 x 17 finds it to well under 1 %.
fn largest_pixel(intrinsics: &Intrinsics) -> f64 {
    let size = DVec2::new(intrinsics.width() as f64, intrinsics.height() as f64) - 1.0;
    let mut largest = (1.0 / intrinsics.focal()).max_element();
    for (i, j) in (0..17).flat_map(|i| (0..17).map(move |j| (i, j))) {
        let pixel = size * DVec2::new(i as f64, j as f64) / 16.0;
        for step in [DVec2::X, DVec2::Y] {
            if let (Some(a), Some(b)) = (intrinsics.deproject(pixel), intrinsics.deproject(pixel + step)) {
                largest = largest.max(a.distance(b));
            }
        }
    }
    largest
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::view::look_at;

    #[test]
    fn views_have_a_bounded_number_of_rays() {
        let grid = RayGrid::new(&Intrinsics::d435i());
        let camera = look_at(DVec3::X, DVec3::ZERO).unwrap();
        let check = |bounds: Aabb, spacing: f64| grid.cells(&camera, &bounds, spacing).len();
        let corners = |middle: DVec3| Aabb::cube(middle, 1.0).corners();
        let near = Aabb::cube(DVec3::ZERO, 0.1);
        assert!((1..100_000).contains(&check(near, 0.005)));
        let dense = check(near, 1e-9);
        assert!(dense > 1 << 21 && dense <= 1 << 22, "{dense}");
        assert!(
            !grid.may_show(&corners(DVec3::new(0.0, 2e6, 1e6))) && !grid.may_show(&corners(DVec3::Z * -1e3))
        );
        assert!(grid.may_show(&corners(DVec3::Z * 1e6)) && grid.may_show(&corners(DVec3::Y * 0.5)));
        for middle in [DVec3::new(-1e6, 2e6, 0.0), DVec3::new(-1.0, 1e6, 0.0), DVec3::X * 1e6] {
            assert!(check(Aabb::cube(middle, 1.0), 0.01) <= 1 << 22);
        }
        let far = check(Aabb::cube(DVec3::new(-1e6, 0.0, 0.0), 1.0), 0.01);
        assert!((1..=1 << 22).contains(&far), "{far}");
        let thin = Aabb { min: DVec3::new(-1e-9, -0.1, 0.0), max: DVec3::new(1e-9, 0.1, 1e-12) };
        assert!((1..=1 << 22).contains(&check(thin, 1e-9)));
        // No columns, and an infinite number of rows.
        let beside = Aabb::cube(DVec3::new(0.0, 5.0, 0.0), 0.1);
        let cells = grid.cells(&camera, &beside, f64::MIN_POSITIVE);
        assert_eq!((cells.columns, cells.rows), (0, 0));
    }
}
