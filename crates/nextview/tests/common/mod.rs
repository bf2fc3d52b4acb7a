//! The rays of a view and their voxels, without the library's grid and walk.

use glam::{DVec2, DVec3, IVec3};
use nextview::geometry::{Aabb, Pose, VoxelBlock};
use nextview::sensor::{Distortion, Intrinsics};

/// The voxels of a block that a ray crosses, in order: every column of voxels is cut with the ray, and every
/// voxel of it. Origin and direction are in voxels. Touching an edge or a corner is no crossing.
pub fn crossed(block: VoxelBlock, origin: DVec3, direction: DVec3) -> Vec<IVec3> {
    // From where to where a ray is between two faces of a voxel.
    let between = |axis: usize, index: i32| {
        let faces = [index, index + 1].map(|face| f64::from(face) - origin[axis]);
        if direction[axis] == 0.0 {
            return if faces[0] <= 0.0 && 0.0 < faces[1] { (0.0, f64::INFINITY) } else { (0.0, 0.0) };
        }
        let [a, b] = faces.map(|face| face / direction[axis]);
        (a.min(b), a.max(b))
    };
    let both = |a: (f64, f64), b: (f64, f64)| (a.0.max(b.0), a.1.min(b.1));
    let is_crossed = |part: (f64, f64)| part.1 - part.0 > 1e-9;
    let indices = |axis: usize| block.min()[axis]..block.min()[axis] + block.dims()[axis] as i32;
    let mut parts = Vec::new();
    for x in indices(0) {
        for y in indices(1) {
            let column = both(both((0.0, f64::INFINITY), between(0, x)), between(1, y));
            if is_crossed(column) {
                let part = |z| (both(column, between(2, z)), IVec3::new(x, y, z));
                parts.extend(indices(2).map(part).filter(|(part, _)| is_crossed(*part)));
            }
        }
    }
    parts.sort_by(|a, b| a.0.0.total_cmp(&b.0.0));
    parts.into_iter().map(|(_, key)| key).collect()
}

/// Returns the directions (camera frame, z = 1) of rays towards a box: through the middles of equal cells of
/// the part of the image that shows its corners. At the far side of the box, neighbouring rays are at most
/// `spacing` apart. The library's limit to the number of rays is left out.
pub fn directions(camera: &Intrinsics, pose: &Pose, bounds: &Aabb, spacing: f64) -> Vec<DVec3> {
    let size = DVec2::new(f64::from(camera.width()), f64::from(camera.height()));
    // The largest width of a pixel one metre away, at 17 x 17 places.
    let mut pixel_m = (1.0 / camera.focal().x).max(1.0 / camera.focal().y);
    for place in (0..17 * 17).map(|i| DVec2::new(f64::from(i % 17), f64::from(i / 17)) / 16.0) {
        let pixel = (size - 1.0) * place;
        let ends = [pixel, pixel + DVec2::X, pixel + DVec2::Y].map(|pixel| camera.deproject(pixel));
        let [Some(here), right, below] = ends else { continue };
        for next in [right, below].into_iter().flatten() {
            pixel_m = pixel_m.max(here.distance(next));
        }
    }
    let mut corners = Vec::new();
    for i in 0..8 {
        let end = |bit: usize, low: f64, high: f64| if i >> bit & 1 == 0 { low } else { high };
        let corner = [0, 1, 2].map(|axis| end(axis, bounds.min[axis], bounds.max[axis]));
        corners.push(pose.inverse().transform_point(DVec3::from_array(corner)));
    }
    let farthest = corners.iter().map(|corner| corner.z).fold(0.0, f64::max);
    if farthest == 0.0 {
        return Vec::new();
    }
    let (mut low, mut high) = (DVec2::splat(-0.5), size - 0.5);
    let pixels: Option<Vec<DVec2>> = corners.iter().map(|&corner| camera.project(corner)).collect();
    // If a corner cannot be projected, it is the whole image.
    if let Some(pixels) = pixels {
        let least = pixels.iter().copied().reduce(DVec2::min).expect("eight corners");
        let most = pixels.iter().copied().reduce(DVec2::max).expect("eight corners");
        // A lens bends edges.
        let margin = if camera.distortion() == Distortion::None { 0.0 } else { 0.02 } * (most - least);
        (low, high) = (low.max(least - margin), high.min(most + margin));
    }
    let n = ((high - low) * (farthest * pixel_m) / spacing).ceil();
    let mut directions = Vec::new();
    for row in 0..n.y.max(0.0) as u32 {
        for column in 0..n.x.max(0.0) as u32 {
            let cell = DVec2::new(f64::from(column) + 0.5, f64::from(row) + 0.5);
            directions.extend(camera.deproject(low + (high - low) / n * cell).map(|ideal| ideal.extend(1.0)));
        }
    }
    directions
}
