//! Rules that make view candidates around an object. All look at the object's centre, which must be within
//! [`Pose::REACH`](crate::geometry::Pose::REACH).

use super::{ViewSpace, look_at};
use crate::Error;
use crate::checked::check_range;
use crate::geometry::random::Random;
use crate::geometry::{check_position, sphere};
use glam::{DVec2, DVec3};
use std::f64::consts::{FRAC_PI_2, TAU};

/// The paper's random shell: positions uniform outside the cube of half-side `2 * size` and inside the sphere
/// of radius `4 * size`, both around `center`; `size` is half the longest side of the object's box, metres.
pub fn shell(center: DVec3, size: f64, n: usize, seed: u64) -> Result<ViewSpace, Error> {
    check(size, n)?;
    let mut random = Random::new(seed, 0);
    let mut position = || loop {
        let offset = random.in_cube() * 4.0;
        if offset.length_squared() <= 16.0 && offset.abs().max_element() >= 2.0 {
            return center + offset * size;
        }
    };
    looking_at(center, (0..n).map(|_| position()))
}

/// Returns positions on a Fibonacci sphere of this radius (metres) around `center`.
pub fn fibonacci_sphere(center: DVec3, radius: f64, n: usize) -> Result<ViewSpace, Error> {
    on_sphere(center, radius, n, |n| (0..n).map(|i| sphere::fibonacci(i, n)).collect())
}

/// Returns positions on the upper half of a Fibonacci sphere of this radius (metres) around `center`, for an
/// object on a table: no candidate is below the centre's height.
pub fn hemisphere(center: DVec3, radius: f64, n: usize) -> Result<ViewSpace, Error> {
    on_sphere(center, radius, n, |n| (0..n).map(|i| sphere::fibonacci_hemisphere(i, n)).collect())
}

/// Returns positions on a sphere of this radius (metres) around `center`, as far apart as possible (Tammes'
/// problem): the candidates of ObjView-Bench (arXiv 2605.10707). At most [`MOST_TAMMES`], since all pairs are
/// compared.
pub fn tammes(center: DVec3, radius: f64, n: usize) -> Result<ViewSpace, Error> {
    if n > MOST_TAMMES {
        return Err(Error::invalid(
            "number of view candidates",
            n,
            "at most 1000 that are as far apart as possible",
        ));
    }
    on_sphere(center, radius, n, sphere::tammes)
}

/// Maximum number of candidates of [`tammes`].
pub const MOST_TAMMES: usize = 1000;

/// Returns positions on 24 rings of latitude of a sphere of this radius (metres) around `center`, as in
/// PB-NBV (Jia et al., RA-L 2025).
pub fn latitude_rings(center: DVec3, radius: f64, n: usize) -> Result<ViewSpace, Error> {
    on_sphere(center, radius, n, |n| sphere::latitude_rings(n, N_RINGS))
}

const N_RINGS: usize = 24;

/// Returns positions on a circle at this distance (metres) from `center` and this angle (radians, below pi /
/// 2) above it: a fixed camera as seen from an object on a turntable. Candidate i shows the object after the
/// table has turned by i / n of a turn counter-clockwise, seen from above; at 0, the camera is at +x.
pub fn ring(center: DVec3, distance: f64, elevation: f64, n: usize) -> Result<ViewSpace, Error> {
    check(distance, n)?;
    check_range("elevation", elevation, -LIMIT_OF_RING..=LIMIT_OF_RING, "less than pi / 2 up or down")?;
    let (sin, cos) = elevation.sin_cos();
    let turned = |i: usize| DVec2::from_angle(-TAU * i as f64 / n as f64) * cos;
    looking_at(center, (0..n).map(|i| center + turned(i).extend(sin) * distance))
}

/// Straight above, a camera has no horizon.
const LIMIT_OF_RING: f64 = FRAC_PI_2 - 1e-6;

fn on_sphere(
    center: DVec3,
    radius: f64,
    n: usize,
    directions: fn(usize) -> Vec<DVec3>,
) -> Result<ViewSpace, Error> {
    check(radius, n)?;
    looking_at(center, directions(n).into_iter().map(|direction| center + direction * radius))
}

fn looking_at(center: DVec3, positions: impl Iterator<Item = DVec3>) -> Result<ViewSpace, Error> {
    check_position("center", center)?;
    ViewSpace::new(positions.map(|position| look_at(position, center)).collect::<Result<_, _>>()?)
}

fn check(length: f64, n: usize) -> Result<(), Error> {
    if !(length > 0.0 && length.is_finite()) {
        return Err(Error::invalid("object size or view distance", length, "a positive length in metres"));
    }
    if n == 0 || n > 10_000_000 {
        return Err(Error::invalid("number of view candidates", n, "1 to 10,000,000"));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DQuat;

    #[test]
    fn the_shell_lies_between_cube_and_sphere_and_looks_inward() {
        let (center, size) = (DVec3::new(0.1, -0.2, 0.3), 0.07);
        let views = shell(center, size, 500, 7).unwrap();
        for pose in views.poses() {
            let offset = pose.translation() - center;
            assert!(offset.length() <= 4.0 * size && offset.abs().max_element() >= 2.0 * size);
            assert!(offset.normalize().dot(pose.rotation() * DVec3::Z) < -1.0 + 1e-12);
        }
        assert_eq!(views, shell(center, size, 500, 7).unwrap());
        assert_ne!(views, shell(center, size, 500, 8).unwrap());
    }

    #[test]
    fn more_candidates_of_one_seed_begin_with_the_same() {
        let few = shell(DVec3::ZERO, 0.1, 10, 3).unwrap();
        assert_eq!(few.poses(), &shell(DVec3::ZERO, 0.1, 20, 3).unwrap().poses()[..10]);
    }

    #[test]
    fn the_hemisphere_stays_above() {
        for pose in hemisphere(DVec3::ZERO, 0.4, 300).unwrap().poses() {
            assert!(pose.translation().z > 0.0 && (pose.translation().length() - 0.4).abs() < 1e-12);
        }
    }

    #[test]
    fn the_ring_is_what_a_turntable_shows() {
        let center = DVec3::new(0.1, -0.2, 0.3);
        let views = ring(center, 0.4, 0.5, 12).unwrap();
        let first = views.pose(0).translation() - center;
        assert!((first - DVec3::new(0.5_f64.cos(), 0.0, 0.5_f64.sin()) * 0.4).length() < 1e-15);
        for view in 0..12 {
            // The camera is fixed; the object turns counter-clockwise.
            let turned = DQuat::from_rotation_z(TAU * view as f64 / 12.0);
            let seen_from = turned * (views.pose(view).translation() - center);
            assert!(seen_from.distance(first) < 1e-15);
        }
    }

    #[test]
    fn refuses_no_views_and_no_size() {
        assert!(shell(DVec3::ZERO, 0.1, 0, 0).is_err());
        assert!(shell(DVec3::ZERO, -0.1, 5, 0).is_err());
        assert!(fibonacci_sphere(DVec3::ZERO, f64::NAN, 5).is_err());
        assert!(fibonacci_sphere(DVec3::ZERO, 1e9, 5).is_err());
        assert!(ring(DVec3::ZERO, 0.4, FRAC_PI_2, 5).is_err());
    }

    #[test]
    fn refuses_a_centre_that_is_no_place() {
        for bad in [f64::NAN, f64::INFINITY, 1e300].map(|x| DVec3::new(x, 0.0, 0.0)) {
            let all = [shell(bad, 0.1, 5, 0), fibonacci_sphere(bad, 0.4, 5), hemisphere(bad, 0.4, 5)];
            for views in all {
                assert!(views.unwrap_err().to_string().starts_with("center is "));
            }
        }
    }
}
