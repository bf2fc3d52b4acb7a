//! Directions on the unit sphere.

use glam::DVec3;
use std::f64::consts::{PI, TAU};

/// Returns direction `i` of `n` on the Fibonacci sphere: nearly uniform, from near +z down to near -z.
///
/// `i` must be below `n`.
pub fn fibonacci(i: usize, n: usize) -> DVec3 {
    let z = 1.0 - (2 * i + 1) as f64 / n as f64;
    ring_point(i, z)
}

/// Returns direction `i` of `n` on the upper half of the Fibonacci sphere, from near +z down to near the
/// horizon.
pub fn fibonacci_hemisphere(i: usize, n: usize) -> DVec3 {
    let z = 1.0 - (i as f64 + 0.5) / n as f64;
    ring_point(i, z)
}

fn ring_point(i: usize, z: f64) -> DVec3 {
    let golden_angle = PI * (3.0 - 5.0_f64.sqrt());
    let radius = (1.0 - z * z).sqrt();
    let (sin, cos) = (golden_angle * i as f64).sin_cos();
    DVec3::new(radius * cos, radius * sin, z)
}

/// Powers of the inverse distance by which the rounds of [`tammes`] repel, one after another.
const POWERS: [i32; 4] = [2, 4, 8, 16];
const ROUNDS_PER_POWER: usize = 100;

/// Returns `n` directions as far apart as possible (Tammes' problem): those of the Fibonacci sphere, which
/// then repel each other. The smallest angle is close to the largest possible one, but not exactly it.
pub fn tammes(n: usize) -> Vec<DVec3> {
    let mut directions: Vec<DVec3> = (0..n).map(|i| fibonacci(i, n)).collect();
    // Approximate distance of neighbours.
    let apart = (4.0 * PI / n.max(1) as f64).sqrt();
    for power in POWERS {
        let mut step = 0.1 * apart;
        let mut before = energy(&directions, apart, power);
        for _ in 0..ROUNDS_PER_POWER {
            let moved = repelled(&directions, apart, power, step);
            let after = energy(&moved, apart, power);
            if after < before {
                (directions, before) = (moved, after);
            } else {
                step *= 0.5;
            }
        }
    }
    directions
}

/// Returns the sum over all pairs, with distances in units of `apart` so that powers do not overflow.
fn energy(directions: &[DVec3], apart: f64, power: i32) -> f64 {
    let pairs = directions.iter().enumerate().flat_map(|(i, a)| directions[..i].iter().map(move |b| (a, b)));
    pairs.map(|(a, b)| (apart / a.distance(*b)).powi(power)).sum()
}

/// Returns all directions pushed away from each other, the one pushed most by `step`.
fn repelled(directions: &[DVec3], apart: f64, power: i32, step: f64) -> Vec<DVec3> {
    let push = |a: &DVec3| -> DVec3 {
        let others = directions.iter().map(|b| *a - *b).filter(|offset| *offset != DVec3::ZERO);
        let push: DVec3 = others
            .map(|offset| offset / offset.length_squared() * (apart / offset.length()).powi(power))
            .sum();
        push - *a * push.dot(*a)
    };
    let pushes: Vec<DVec3> = directions.iter().map(push).collect();
    let most = pushes.iter().map(|push| push.length()).fold(f64::MIN_POSITIVE, f64::max);
    directions.iter().zip(pushes).map(|(a, push)| (*a + push * (step / most)).normalize()).collect()
}

/// Returns `n` directions on rings of latitude, from the top down. Their number on each ring is proportional
/// to its length; they begin at +x, counter-clockwise as seen from above.
pub fn latitude_rings(n: usize, n_rings: usize) -> Vec<DVec3> {
    let polar_angle = |ring: usize| PI * (ring as f64 + 0.5) / n_rings as f64;
    let lengths: Vec<f64> = (0..n_rings).map(|ring| polar_angle(ring).sin()).collect();
    let whole: f64 = lengths.iter().sum();
    let mut directions = Vec::with_capacity(n);
    let mut share = 0.0;
    for (ring, length) in lengths.iter().enumerate() {
        share += length / whole;
        // Rounded sums end at n; rounded shares may not.
        let n_here = ((share * n as f64).round() as usize).saturating_sub(directions.len());
        let (sin, cos) = polar_angle(ring).sin_cos();
        directions.extend((0..n_here).map(|i| {
            let (y, x) = (TAU * i as f64 / n_here as f64).sin_cos();
            DVec3::new(x * sin, y * sin, cos)
        }));
    }
    directions
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn directions_are_unit_and_spread() {
        let n = 200;
        let sum: DVec3 = (0..n).map(|i| fibonacci(i, n)).sum();
        assert!(sum.length() / (n as f64) < 0.01);
        for i in 0..n {
            assert!((fibonacci(i, n).length() - 1.0).abs() < 1e-12);
            assert!(fibonacci_hemisphere(i, n).z > 0.0);
            let nearest = (0..n).filter(|&j| j != i).map(|j| fibonacci(i, n).distance(fibonacci(j, n)));
            assert!(nearest.fold(f64::INFINITY, f64::min) > 0.1, "no two directions fall together");
        }
        assert!(fibonacci(0, 1).is_finite());
    }

    fn smallest_angle(directions: &[DVec3]) -> f64 {
        let pairs = (0..directions.len()).flat_map(|i| (0..i).map(move |j| (i, j)));
        pairs.map(|(i, j)| directions[i].angle_between(directions[j])).fold(f64::INFINITY, f64::min)
    }

    /// The best known angles are from Sloane's tables of spherical codes.
    #[test]
    fn repelled_directions_are_almost_as_far_apart_as_any() {
        for (n, best_deg) in [(4, 109.471), (6, 90.0), (12, 63.435), (24, 43.691)] {
            let angle = smallest_angle(&tammes(n)).to_degrees();
            assert!((0.93 * best_deg..=best_deg + 1e-3).contains(&angle), "{n}: {angle} of {best_deg}");
        }
        let fibonacci: Vec<DVec3> = (0..128).map(|i| fibonacci(i, 128)).collect();
        assert!(smallest_angle(&tammes(128)) > 1.1 * smallest_angle(&fibonacci));
        assert_eq!(tammes(128), tammes(128));
        assert_eq!((tammes(0).len(), tammes(1).len()), (0, 1));
    }

    #[test]
    fn rings_have_as_many_directions_as_their_length_asks_for() {
        let directions = latitude_rings(800, 24);
        assert_eq!(directions.len(), 800);
        assert!(directions.iter().all(|direction| (direction.length() - 1.0).abs() < 1e-12));
        let mut heights: Vec<f64> = directions.iter().map(|direction| direction.z).collect();
        heights.dedup();
        assert_eq!(heights.len(), 24);
        let on = |height: f64| directions.iter().filter(|direction| direction.z == height).count();
        assert!(on(heights[0]) < 5 && on(heights[11]) > 50 && on(heights[11]).abs_diff(on(heights[12])) <= 1);
    }
}
