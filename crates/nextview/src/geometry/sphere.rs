//! Directions on the unit sphere.

use glam::DVec3;
use std::f64::consts::PI;

/// Direction `i` of `n` on the Fibonacci sphere: nearly uniform, from near +z down to near -z.
///
/// `i` must be below `n`.
pub fn fibonacci(i: usize, n: usize) -> DVec3 {
    let z = 1.0 - (2 * i + 1) as f64 / n as f64;
    ring_point(i, z)
}

/// Direction `i` of `n` on the upper half of the Fibonacci sphere, from near +z down to near the horizon.
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
}
