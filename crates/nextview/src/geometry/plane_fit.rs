use super::Plane;
use super::random::Random;
use crate::{Cancel, Cancelled};
use glam::{DMat2, DVec2, DVec3};

/// Distance, metres, within which a point belongs to a plane: several times the noise of a depth camera near
/// a table.
const INLIER_DISTANCE: f64 = 0.005;
/// Inlier distance of the last fit, as a share: it then includes fewer points of things on the table, which
/// would tilt it.
const CLOSE_SHARE: f64 = 0.4;
/// Largest deviation of inliers, as a share of the inlier distance, that can be trusted: a normal
/// distribution cut off at twice its deviation has 0.44; a uniform one, the appearance of far larger noise,
/// has 0.58.
const LARGEST_DEVIATION: f64 = 0.45;
/// Number of inlier distances tried, each twice the last, for larger noise: up to 4 cm, the noise of a stereo
/// camera at two or three metres.
const N_DISTANCES: u32 = 4;
/// Number of points on which planes are tested, evenly drawn from all.
const N_TRIED: usize = 4000;
/// Number of triples drawn. A plane with a twentieth of the points is then found with a probability of 92 %,
/// one with a tenth almost certainly.
const N_DRAWS: usize = 20_000;
/// Number of triples drawn if most points are known to lie on the plane: a plane with a third of them is
/// found almost certainly.
const N_DRAWS_NEAR: usize = 300;
/// Tilt, degrees, at which a plane's points count half: a plane through an object's top or side may hold more
/// points than a table seen at a grazing angle, but the world's z axis is hardly ever tilted relative to a
/// table.
const HALF_WEIGHT_TILT: f64 = 5.0;
/// Standard deviation of a table's distance from its configured height, as a share of the largest possible
/// one: pose errors hardly ever reach their limit.
const USUAL_SHARE: f64 = 0.2;
/// Cosine of 3 degrees.
const ALIKE: f64 = 0.998_629_534_754_573_9;
/// Minimum share of the points that a plane must hold.
const LEAST_SHARE: f64 = 0.05;
/// Cosine of the largest tilt, 30 degrees.
const LEAST_UP: f64 = 0.866_025_403_784_438_6;

/// A plane fitted to points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlaneFit {
    /// The plane, upper side up.
    pub plane: Plane,
    /// Root mean square distance of its points, metres.
    pub deviation: f64,
}

/// Finds the plane that holds most points (metres) below `viewpoint` and within 30 degrees of the horizontal:
/// a table, not a wall or the ceiling. The points of a plane tilted by 5 degrees count half, by 10 degrees a
/// fifth. `None` if no such plane holds a twentieth of the points.
///
/// RANSAC (Fischler & Bolles 1981) with fixed draws, then least squares over the points within 5 and then 2
/// mm; within up to 40 and 16 mm for noisier points.
pub fn fit_ground(points: &[DVec3], viewpoint: DVec3) -> Option<PlaneFit> {
    fit_ground_unless(points, viewpoint, &Cancel::default()).expect("nobody cancels")
}

/// As [`fit_ground`], unless cancelled.
pub(crate) fn fit_ground_unless(
    points: &[DVec3],
    viewpoint: DVec3,
    cancel: &Cancel,
) -> Result<Option<PlaneFit>, Cancelled> {
    fit(points, viewpoint, &Expected { normal: DVec3::Z, stated: None }, N_DRAWS, cancel)
}

/// As [`fit_ground`], for the points within `distance` metres of a rough estimate of the plane; `None` if the
/// result is tilted by more than 3 degrees. Tilts are relative to the estimate.
pub fn fit_ground_near(rough: Plane, distance: f64, points: &[DVec3], viewpoint: DVec3) -> Option<PlaneFit> {
    fit_near(rough, distance, points, viewpoint, None)
}

/// As [`fit_ground_near`], for a configured plane and poses at most `distance` metres off. A plane nearer to
/// the configured one may win with a few times fewer points: otherwise, the flat top of an object that fills
/// the image would pass for the table.
pub(crate) fn fit_ground_stated(
    stated: Plane,
    distance: f64,
    points: &[DVec3],
    viewpoint: DVec3,
) -> Option<PlaneFit> {
    fit_near(stated, distance, points, viewpoint, Some(USUAL_SHARE * distance))
}

fn fit_near(
    rough: Plane,
    distance: f64,
    points: &[DVec3],
    viewpoint: DVec3,
    sigma: Option<f64>,
) -> Option<PlaneFit> {
    let near: Vec<DVec3> = inliers(points, rough, distance).collect();
    let expected = Expected { normal: rough.normal(), stated: sigma.map(|sigma| (rough, sigma)) };
    let found =
        fit(&near, viewpoint, &expected, N_DRAWS_NEAR, &Cancel::default()).expect("nobody cancels")?;
    (found.plane.normal().dot(rough.normal()) >= ALIKE).then_some(found)
}

/// Prior knowledge of a plane.
struct Expected {
    normal: DVec3,
    /// The configured plane, and the standard deviation of its position, metres.
    stated: Option<(Plane, f64)>,
}

fn fit(
    points: &[DVec3],
    viewpoint: DVec3,
    expected: &Expected,
    n_draws: usize,
    cancel: &Cancel,
) -> Result<Option<PlaneFit>, Cancelled> {
    let tried: Vec<DVec3> = points.iter().step_by(points.len().div_ceil(N_TRIED).max(1)).copied().collect();
    let Some((_, plane)) = likeliest_plane(&tried, viewpoint, expected, n_draws, cancel)? else {
        return Ok(None);
    };
    Ok(refined(points, plane))
}

/// Returns the plane near this one that fits the points best, with an inlier distance that matches their
/// noise; `None` if there are no inliers.
fn refined(points: &[DVec3], mut plane: Plane) -> Option<PlaneFit> {
    let mut deviation = None;
    for distance in (0..N_DISTANCES).map(|i| INLIER_DISTANCE * f64::from(1 << i)) {
        plane = least_squares(points, least_squares(points, plane, distance), CLOSE_SHARE * distance);
        let (n, sum) = inliers(points, plane, distance)
            .fold((0, 0.0), |(n, sum), p| (n + 1, sum + plane.height(p).powi(2)));
        deviation = (n > 0).then(|| (sum / n as f64).sqrt());
        if deviation.is_none_or(|deviation| deviation <= LARGEST_DEVIATION * distance) {
            break;
        }
    }
    deviation.map(|deviation| PlaneFit { plane, deviation })
}

/// Returns the plane of greatest weight among those through three drawn points that hold enough of all, and
/// its weight.
fn likeliest_plane(
    points: &[DVec3],
    viewpoint: DVec3,
    expected: &Expected,
    n_draws: usize,
    cancel: &Cancel,
) -> Result<Option<(f64, Plane)>, Cancelled> {
    if points.len() < 3 {
        return Ok(None);
    }
    let mut random = Random::new(0, 0);
    let mut draw = || points[random.index(points.len())];
    let mut likeliest: Option<(f64, Plane)> = None;
    for _ in 0..n_draws {
        cancel.check()?;
        let Some(plane) = ground_through([draw(), draw(), draw()], viewpoint) else { continue };
        let Some(weight) = weight(points, plane, expected) else { continue };
        if likeliest.is_none_or(|(most, _)| weight > most) {
            likeliest = Some((weight, plane));
        }
    }
    Ok(likeliest)
}

/// Returns the number of points near a plane, reduced by its tilt and its distance from the configured plane;
/// `None` if there are too few.
fn weight(points: &[DVec3], plane: Plane, expected: &Expected) -> Option<f64> {
    let n = inliers(points, plane, INLIER_DISTANCE).count() as f64;
    if n < LEAST_SHARE * points.len() as f64 {
        return None;
    }
    let tilt = plane.normal().angle_between(expected.normal).to_degrees();
    let at_height = expected.stated.map_or(1.0, |(stated, sigma)| {
        let heights = inliers(points, plane, INLIER_DISTANCE).map(|point| stated.height(point));
        (-0.5 * (heights.sum::<f64>() / n / sigma).powi(2)).exp()
    });
    Some(n * at_height / (1.0 + (tilt / HALF_WEIGHT_TILT).powi(2)))
}

fn ground_through([a, b, c]: [DVec3; 3], viewpoint: DVec3) -> Option<Plane> {
    let across = (b - a).cross(c - a);
    let plane = Plane::new(if across.z < 0.0 { -across } else { across }, a).ok()?;
    (plane.normal().z >= LEAST_UP && plane.height(viewpoint) > 0.0).then_some(plane)
}

fn inliers(points: &[DVec3], plane: Plane, distance: f64) -> impl Iterator<Item = DVec3> + '_ {
    points.iter().copied().filter(move |point| plane.height(*point).abs() <= distance)
}

/// Returns the plane of least squared vertical distances to the points near this one; this one if they do not
/// span a plane.
fn least_squares(points: &[DVec3], plane: Plane, distance: f64) -> Plane {
    let (n, sum) = inliers(points, plane, distance).fold((0, DVec3::ZERO), |(n, sum), p| (n + 1, sum + p));
    let mean = sum / n as f64;
    let (mut moments, mut with_z) = (DMat2::ZERO, DVec2::ZERO);
    for d in inliers(points, plane, distance).map(|p| p - mean) {
        moments += DMat2::from_cols(d.truncate() * d.x, d.truncate() * d.y);
        with_z += d.truncate() * d.z;
    }
    let slope = moments.inverse() * with_z;
    Plane::new((-slope).extend(1.0), mean).unwrap_or(plane)
}

#[cfg(test)]
mod tests {
    use super::*;

    const EYE: DVec3 = DVec3::new(0.0, -1.0, 1.0);

    /// `n` points of a unit square around the origin, rotated about the x axis and moved, with some noise.
    fn square(n: usize, tilt_deg: f64, at: DVec3, random: &mut Random) -> Vec<DVec3> {
        let turn = glam::DQuat::from_rotation_x(tilt_deg.to_radians());
        let mut point = || turn * (random.in_cube() * DVec3::new(0.5, 0.5, 0.001)) + at;
        (0..n).map(|_| point()).collect()
    }

    fn check_near(fit: PlaneFit, tilt_deg: f64, at: DVec3) {
        let normal = glam::DQuat::from_rotation_x(tilt_deg.to_radians()) * DVec3::Z;
        assert!(fit.plane.normal().angle_between(normal).to_degrees() < 0.3, "{fit:?}");
        assert!(fit.plane.height(at).abs() < 0.0005 && fit.deviation < 0.001, "{fit:?}");
    }

    #[test]
    fn finds_the_table_among_a_larger_wall_a_ceiling_and_things() {
        for tilt in [-20.0, 0.0, 3.0, 28.0] {
            let mut random = Random::new(1, 0);
            let mut points = square(9000, 90.0, DVec3::Y, &mut random);
            points.extend(square(5000, 0.0, DVec3::Z * 2.0, &mut random));
            points.extend((0..3000).map(|_| random.in_cube() * 0.1 + DVec3::Z * 0.1));
            points.extend(square(4000, tilt, DVec3::ZERO, &mut random));
            check_near(fit_ground(&points, EYE).unwrap(), tilt, DVec3::ZERO);
        }
    }

    #[test]
    fn knows_how_noisy_the_points_are() {
        for deviation in [0.0005, 0.002, 0.004, 0.008, 0.015] {
            let mut random = Random::new(6, 0);
            let mut points: Vec<DVec3> = (0..20_000)
                .map(|_| {
                    random.in_cube() * DVec3::new(0.5, 0.5, 0.0) + DVec3::Z * deviation * random.normal()
                })
                .collect();
            points.extend((0..4000).map(|_| random.in_cube() * 0.15 + DVec3::Z * 0.15));
            let fit = fit_ground(&points, EYE).unwrap();
            assert!((fit.deviation / deviation - 1.0).abs() < 0.2, "{deviation}: {fit:?}");
            assert!(fit.plane.height(DVec3::ZERO).abs() < 0.2 * deviation, "{deviation}: {fit:?}");
        }
    }

    #[test]
    fn finds_the_table_beside_a_larger_slope() {
        let mut random = Random::new(4, 0);
        let mut points = square(4000, 20.0, DVec3::Z * 0.3, &mut random);
        points.extend(square(1000, 1.0, DVec3::ZERO, &mut random));
        check_near(fit_ground(&points, EYE).unwrap(), 1.0, DVec3::ZERO);
    }

    #[test]
    fn of_a_stated_table_and_the_top_of_a_box_on_it_the_nearer_one_is_the_table() {
        // A box of 5 cm that fills most of the image, with the pose 2 cm off.
        let mut random = Random::new(5, 0);
        let mut points = square(8000, 0.0, DVec3::Z * 0.03, &mut random);
        points.extend(square(2000, 0.0, DVec3::Z * -0.02, &mut random));
        let stated = Plane::horizontal(0.0).unwrap();
        check_near(fit_ground_stated(stated, 0.05, &points, EYE).unwrap(), 0.0, DVec3::Z * -0.02);
        check_near(fit_ground_near(stated, 0.05, &points, EYE).unwrap(), 0.0, DVec3::Z * 0.03);
        // A turntable above a table at no greater distance.
        let mut points = square(5000, 0.0, DVec3::Z * 0.005, &mut random);
        points.extend(square(5000, 0.0, DVec3::Z * -0.03, &mut random));
        check_near(fit_ground_stated(stated, 0.05, &points, EYE).unwrap(), 0.0, DVec3::Z * 0.005);
    }

    #[test]
    fn finds_nothing_where_there_is_no_table() {
        let mut random = Random::new(2, 0);
        let wall = square(3000, 90.0, DVec3::Y, &mut random);
        let ceiling = square(3000, 0.0, DVec3::Z * 2.0, &mut random);
        let steep = square(3000, 45.0, DVec3::ZERO, &mut random);
        let lone = vec![DVec3::X; 10];
        for points in [wall, ceiling, steep, lone, vec![], vec![DVec3::X], vec![DVec3::NAN; 5]] {
            assert_eq!(fit_ground(&points, EYE), None);
        }
    }

    /// The slow twin: every triple of a few points.
    #[test]
    fn holds_as_many_points_as_the_best_of_all_triples() {
        let up = Expected { normal: DVec3::Z, stated: None };
        for seed in 0..20 {
            let mut random = Random::new(seed, 1);
            let mut points = square(8, 0.0, DVec3::ZERO, &mut random);
            points.extend((0..16).map(|_| random.in_cube() * 0.2));
            let mut most = 0.0_f64;
            for (i, &a) in points.iter().enumerate() {
                for (j, &b) in points.iter().enumerate().skip(i + 1) {
                    for &c in &points[j + 1..] {
                        let plane = ground_through([a, b, c], EYE);
                        most = most.max(plane.and_then(|plane| weight(&points, plane, &up)).unwrap_or(0.0));
                    }
                }
            }
            let found = likeliest_plane(&points, EYE, &up, N_DRAWS, &Cancel::default());
            // The order of three points decides the last bits of their plane's tilt.
            assert!((found.unwrap().unwrap().0 - most).abs() < 1e-9, "seed {seed}");
        }
    }
}
