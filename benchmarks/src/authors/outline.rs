use crate::Outcome;
use glam::{DVec2, DVec3};
use nextview::geometry::{Aabb, Pose};
use nextview::sensor::Intrinsics;

/// The outline of the object's box in an image: the convex hull of its corners.
pub struct Outline {
    hull: Vec<DVec2>,
    /// Number of pixels along an edge of a voxel of this size.
    pub voxel_pixels: f64,
}

impl Outline {
    /// Computes the outline in the image of a camera at this pose, which must be outside the box;
    /// `by_deprojection` distorts with the polynomial for the opposite direction.
    pub fn new(aabb: &Aabb, camera: &Pose, intrinsics: &Intrinsics, by_deprojection: bool) -> Outcome<Self> {
        let to_camera = camera.inverse();
        let mut corners = Vec::new();
        for corner in aabb.corners() {
            let inside = to_camera.transform_point(corner);
            let ideal = inside.truncate() / inside.z;
            let pixel = match by_deprojection {
                true => intrinsics
                    .deproject(ideal * intrinsics.focal() + intrinsics.center())
                    .map(|distorted| distorted * intrinsics.focal() + intrinsics.center()),
                false => intrinsics.project(inside),
            };
            // Without an answer of the lens, the corner is where an ideal lens would show it.
            corners.push((corner, pixel.unwrap_or(ideal * intrinsics.focal() + intrinsics.center())));
        }
        let hull = convex_hull(corners.iter().map(|corner| corner.1).collect());
        let on_hull: Vec<(DVec3, DVec2)> =
            corners.into_iter().filter(|corner| hull.contains(&corner.1)).collect();
        let pixels = widest(on_hull.iter().map(|corner| corner.1.extend(0.0)));
        let metres = widest(on_hull.iter().map(|corner| corner.0));
        if !(pixels > 0.0 && metres > 0.0) {
            return Err(format!("a camera at {} sees no outline of the box", camera.translation()).into());
        }
        Ok(Self { hull, voxel_pixels: pixels / (metres / super::recording::VOXEL_SIZE) })
    }

    /// Returns the inner pixels at this spacing, starting at the whole pixel at the outline's least column
    /// and row.
    pub fn pixels(&self, apart: f64) -> Vec<DVec2> {
        let (low, high) = self
            .hull
            .iter()
            .fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(low, high), &p| (low.min(p), high.max(p)));
        let start = low.floor();
        let n = ((high - start) / apart).ceil().as_uvec2();
        let grid = (0..n.x).flat_map(|u| (0..n.y).map(move |v| DVec2::new(u.into(), v.into())));
        grid.map(|at| start + at * apart).filter(|&pixel| self.contains(pixel)).collect()
    }

    fn contains(&self, pixel: DVec2) -> bool {
        let next = self.hull.iter().cycle().skip(1);
        self.hull.iter().zip(next).all(|(&a, &b)| (b - a).perp_dot(pixel - a) >= 0.0)
    }
}

fn widest(points: impl Iterator<Item = DVec3> + Clone) -> f64 {
    let pairs = points.clone().flat_map(|a| points.clone().map(move |b| a.distance(b)));
    pairs.fold(0.0, f64::max)
}

/// The corners of the convex hull in the direction from x to y (Andrew's monotone chain).
fn convex_hull(mut points: Vec<DVec2>) -> Vec<DVec2> {
    points.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    let mut hull = half_hull(points.iter().copied());
    hull.extend(half_hull(points.iter().rev().copied()));
    hull
}

fn half_hull(points: impl Iterator<Item = DVec2>) -> Vec<DVec2> {
    let mut half: Vec<DVec2> = Vec::new();
    for point in points {
        while let [.., a, b] = half[..]
            && (b - a).perp_dot(point - a) <= 0.0
        {
            half.pop();
        }
        half.push(point);
    }
    half.pop();
    half
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_hull_of_a_square_with_a_point_inside_is_the_square() {
        let points = [(1.0, 1.0), (0.0, 0.0), (2.0, 2.0), (2.0, 0.0), (0.0, 2.0)];
        let hull = convex_hull(points.map(DVec2::from).to_vec());
        assert_eq!(hull, [(0.0, 0.0), (2.0, 0.0), (2.0, 2.0), (0.0, 2.0)].map(DVec2::from));
    }
}
