//! Pixels where a stereo camera has no depth.
//!
//! Everything is computed from the inverse depth, which is linear in the image of a plane: with the plane's
//! normal n and distance d from the camera, 1 / z = n / d . (x, y, 1) where the ray is z (x, y, 1). The lens
//! is treated as a pinhole here.

use super::SensorNoise;
use glam::DVec3;
use nextview::sensor::Intrinsics;

/// The probability, 0..=1, that a pixel of the exact image is lost; 1 for pixels without a surface.
pub(super) fn probabilities(noise: &SensorNoise, exact: &[f32], intrinsics: &Intrinsics) -> Vec<f32> {
    let width = intrinsics.width() as usize;
    let inverse: Vec<f32> = exact.iter().map(|depth| 1.0 / depth).collect();
    let disparity_at_1_m = (intrinsics.focal().x * noise.baseline) as f32;
    let measured = (1.0 / noise.max_depth) as f32..=inverse_limit(noise.min_depth);
    let mut loss = vec![1.0; exact.len()];
    for v in 0..intrinsics.height() as usize {
        let is_hidden = hidden(&inverse[v * width..][..width], disparity_at_1_m);
        for u in (0..width).filter(|u| !is_hidden[*u]) {
            let here = inverse[v * width + u];
            if measured.contains(&here) {
                let slopes = Slopes::new(&inverse, width, u, v);
                let is_edge = slopes.steepest * disparity_at_1_m > noise.edge_gradient as f32;
                let edge = if is_edge { noise.edge_loss } else { 0.0 };
                let grazing = grazing_loss(noise, intrinsics, [u, v], here as f64, &slopes);
                loss[v * width + u] = (1.0 - (1.0 - edge) * (1.0 - grazing)) as f32;
            }
        }
    }
    loss
}

fn inverse_limit(min_depth: f64) -> f32 {
    if min_depth > 0.0 { (1.0 / min_depth) as f32 } else { f32::MAX }
}

/// The pixels of a row that the second camera, to the right of the first, does not see. It sees pixel u at u
/// minus the disparity; u is hidden if a pixel to its right appears there or farther left.
fn hidden(inverse: &[f32], disparity_at_1_m: f32) -> Vec<bool> {
    let mut is_hidden = vec![false; inverse.len()];
    let mut leftmost = f32::INFINITY;
    for (u, is_hidden) in is_hidden.iter_mut().enumerate().rev() {
        let seen_at = u as f32 - disparity_at_1_m * inverse[u];
        *is_hidden = seen_at >= leftmost;
        leftmost = leftmost.min(seen_at);
    }
    is_hidden
}

/// Changes of the inverse depth from a pixel to its neighbours, 1/m per pixel.
struct Slopes {
    /// To the right and down, on the side with the smaller change: there is another surface across an edge.
    gentlest: [f32; 2],
    /// The largest of all four.
    steepest: f32,
}

impl Slopes {
    fn new(inverse: &[f32], width: usize, u: usize, v: usize) -> Self {
        let here = v * width + u;
        let at = |index: usize| inverse.get(index).copied().unwrap_or(f32::NAN);
        let left = if u > 0 { inverse[here] - inverse[here - 1] } else { f32::NAN };
        let right = if u + 1 < width { inverse[here + 1] - inverse[here] } else { f32::NAN };
        let up = if v > 0 { inverse[here] - inverse[here - width] } else { f32::NAN };
        let down = at(here + width) - inverse[here];
        let steepest =
            [left, right, up, down].into_iter().fold(0.0, |steepest: f32, s| steepest.max(s.abs()));
        Self { gentlest: [gentler(left, right), gentler(up, down)], steepest }
    }
}

/// The smaller of two slopes; the other one if one is NaN.
fn gentler(a: f32, b: f32) -> f32 {
    if b.is_nan() || a.abs() <= b.abs() { a } else { b }
}

/// The loss at the angle between the pixel's ray and the normal of the plane through its gentler neighbours;
/// 1 if there are none.
fn grazing_loss(
    noise: &SensorNoise,
    intrinsics: &Intrinsics,
    [u, v]: [usize; 2],
    inverse: f64,
    slopes: &Slopes,
) -> f64 {
    let (focal, center) = (intrinsics.focal(), intrinsics.center());
    let ray = DVec3::new((u as f64 - center.x) / focal.x, (v as f64 - center.y) / focal.y, 1.0);
    let [x, y] = [slopes.gentlest[0] as f64 * focal.x, slopes.gentlest[1] as f64 * focal.y];
    let normal = DVec3::new(x, y, inverse - x * ray.x - y * ray.y);
    // Most pixels are far from grazing, and need no root.
    let lengths_sq = normal.length_squared() * ray.length_squared();
    if inverse * inverse >= lengths_sq * noise.grazing_from.cos().powi(2) {
        return 0.0;
    }
    let cosine = inverse / lengths_sq.sqrt();
    if cosine.is_nan() { 1.0 } else { noise.grazing_loss(cosine.acos()) }
}
