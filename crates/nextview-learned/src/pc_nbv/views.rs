//! The 33 views of PC-NBV.

use glam::DVec3;
use nextview::geometry::Aabb;
use std::f64::consts::FRAC_1_SQRT_2;

/// Number of views.
pub const N_VIEWS: usize = 33;

/// Direction of view `k` from the centre of the box, z up: the pole, and then eight azimuths, 45 degrees
/// apart starting at the x axis, at each of the elevations 60, 30, 0 and -30 degrees.
pub const DIRECTIONS: [DVec3; N_VIEWS] = {
    let mut directions = [DVec3::Z; N_VIEWS];
    let mut view = 1;
    while view < N_VIEWS {
        let ([x, y], [radius, z]) = (AZIMUTHS[(view - 1) % 8], ELEVATIONS[(view - 1) / 8]);
        directions[view] = DVec3::new(radius * x, radius * y, z);
        view += 1;
    }
    directions
};

/// Cosine and sine of each azimuth. Written out, because they differ between machines.
const AZIMUTHS: [[f64; 2]; 8] = [
    [1.0, 0.0],
    [FRAC_1_SQRT_2, FRAC_1_SQRT_2],
    [0.0, 1.0],
    [-FRAC_1_SQRT_2, FRAC_1_SQRT_2],
    [-1.0, 0.0],
    [-FRAC_1_SQRT_2, -FRAC_1_SQRT_2],
    [0.0, -1.0],
    [FRAC_1_SQRT_2, -FRAC_1_SQRT_2],
];

/// Cosine and sine of each elevation.
const ELEVATIONS: [[f64; 2]; 4] = [[0.5, COS_30], [COS_30, 0.5], [1.0, 0.0], [COS_30, -0.5]];

/// Half the square root of 3.
const COS_30: f64 = 0.866_025_403_784_438_6;

/// Returns which views are nearest in angle to a camera at one of these positions around the box: the visited
/// ones.
pub fn visited(bounds: &Aabb, positions: impl IntoIterator<Item = DVec3>) -> [bool; N_VIEWS] {
    let mut visited = [false; N_VIEWS];
    for position in positions {
        let offset = position - bounds.center();
        let nearer = |best: usize, view: usize| {
            if offset.dot(DIRECTIONS[view]) > offset.dot(DIRECTIONS[best]) { view } else { best }
        };
        visited[(1..N_VIEWS).fold(0, nearer)] = true;
    }
    visited
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn directions_are_those_of_the_paper() {
        assert_eq!(DIRECTIONS[0], DVec3::Z);
        for (n, elevation) in [60.0_f64, 30.0, 0.0, -30.0].into_iter().enumerate() {
            for step in 0..8 {
                let (sin, cos) = elevation.to_radians().sin_cos();
                let azimuth = (45.0 * step as f64).to_radians();
                let expected = DVec3::new(cos * azimuth.cos(), cos * azimuth.sin(), sin);
                assert!(DIRECTIONS[1 + 8 * n + step].distance(expected) < 1e-15);
            }
        }
    }

    #[test]
    fn visited_views_are_the_nearest_to_the_positions() {
        let bounds = Aabb::cube(DVec3::new(0.1, -0.2, 0.3), 0.2);
        let all = DIRECTIONS.map(|direction| bounds.center() + 0.7 * direction);
        for (view, position) in all.into_iter().enumerate() {
            let off = position + DVec3::new(0.05, -0.03, 0.04);
            let found = visited(&bounds, [position, off]);
            assert!((0..N_VIEWS).all(|other| found[other] == (other == view)), "{view}");
        }
        assert_eq!(visited(&bounds, all), [true; N_VIEWS]);
        assert_eq!(visited(&bounds, []), [false; N_VIEWS]);
    }
}
