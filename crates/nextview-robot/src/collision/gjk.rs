//! The distance between convex solids by the algorithm of Gilbert, Johnson and Keerthi (1988).

use super::simplex::Simplex;
use super::solid::{Placement, Solid};
use glam::DVec3;

/// Maximum number of steps; most pairs need about ten. After these, the bound is low but still valid.
const MOST_STEPS: usize = 64;

/// Relative accuracy at which a bound is good enough.
const ACCURACY: f64 = 1e-4;

/// Values below this are zero, in metres.
const NOTHING: f64 = 1e-9;

/// A lower bound on the distance between two solids in metres: within 1e-4 of it, or at least `limit`; 0 if
/// they touch.
///
/// The distance of two convex solids is that of their Minkowski difference from the origin. In any direction,
/// the supporting plane of the difference bounds it. The result is therefore a lower bound even without
/// convergence, and despite rounding in the simplex.
pub(super) fn distance(a: &Solid, b: &Solid, a_from_b: &Placement, limit: f64) -> f64 {
    let b_from_a = a_from_b.rotation.transpose();
    let lowest = |direction: DVec3| {
        let of_b = a_from_b.rotation * b.support(b_from_a * direction) + a_from_b.translation;
        a.support(-direction) - of_b
    };
    let round = a.round() + b.round();
    let mut simplex = Simplex::default();
    let mut nearest = -a_from_b.translation;
    if nearest.length_squared() < NOTHING * NOTHING {
        nearest = DVec3::X;
    }
    let (mut bound, mut upper) = (0.0_f64, f64::INFINITY);
    for _ in 0..MOST_STEPS {
        let length = nearest.length();
        let support = lowest(nearest);
        bound = bound.max(nearest.dot(support) / length);
        let is_near = upper * (1.0 - ACCURACY) <= bound + NOTHING;
        if bound >= limit + round || is_near || simplex.points().contains(&support) {
            break;
        }
        simplex.push(support);
        nearest = simplex.reduce();
        if simplex.points().len() == 4 || nearest.length_squared() < NOTHING * NOTHING {
            return 0.0;
        }
        upper = nearest.length();
    }
    (bound - round).max(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ShapeKind;
    use glam::DQuat;
    use nextview::geometry::Pose;
    use nextview::geometry::random::Random;

    fn kind(random: &mut Random) -> ShapeKind {
        let mut size = || random.range(0.02, 0.5);
        let (x, y, z) = (size(), size(), size());
        match random.index(4) {
            0 => ShapeKind::Box(DVec3::new(x, y, z)),
            1 => ShapeKind::Sphere(x),
            2 => ShapeKind::Cylinder { radius: x, length: 2.0 * y },
            _ => ShapeKind::Hull((0..12).map(|_| random.in_cube() * x + DVec3::splat(z)).collect()),
        }
    }

    fn placement(random: &mut Random) -> Placement {
        let turn = DQuat::from_xyzw(
            random.range(-1.0, 1.0),
            random.range(-1.0, 1.0),
            random.range(-1.0, 1.0),
            random.range(-1.0, 1.0),
        );
        Pose::new(turn.normalize(), 0.8 * random.in_cube()).unwrap().into()
    }

    /// The slow twin descends along both surfaces with alternating Frank-Wolfe supports, the simplest way to
    /// the nearest points, which converges slowly.
    fn slow_distance(a: &Solid, b: &Solid, a_from_b: &Placement) -> f64 {
        let r = a_from_b.rotation;
        let lowest = |v: DVec3| a.support(-v) - (r * b.support(r.transpose() * v) + a_from_b.translation);
        let mut v = lowest(DVec3::X);
        for _ in 0..20_000 {
            let step = lowest(v) - v;
            if step.length_squared() < 1e-24 {
                break;
            }
            v += step * (-v.dot(step) / step.length_squared()).clamp(0.0, 1.0);
        }
        (v.length() - a.round() - b.round()).max(0.0)
    }

    #[test]
    fn distances_are_those_of_the_slow_twin_and_never_larger() {
        let mut random = Random::new(11, 0);
        let mut n_apart = 0;
        for _ in 0..400 {
            let (a, b) = (Solid::new(&kind(&mut random)).0, Solid::new(&kind(&mut random)).0);
            let a_from_b = placement(&mut random);
            let (found, slow) =
                (distance(&a, &b, &a_from_b, f64::INFINITY), slow_distance(&a, &b, &a_from_b));
            assert!(
                found <= slow + 1e-9 && slow <= found + 2e-3 + 1e-3 * slow,
                "{found}, {slow}: {a:?} {b:?}"
            );
            n_apart += usize::from(slow > 0.01);
            let limited = distance(&a, &b, &a_from_b, 0.5 * slow);
            assert!(limited <= slow + 1e-9 && limited >= 0.5 * found * 0.999);
        }
        assert!(n_apart > 150, "{n_apart}");
    }

    /// Random points in both solids are never closer than the distance and, if dense, hardly farther.
    #[test]
    fn sampled_points_are_never_nearer() {
        let mut random = Random::new(12, 0);
        for _ in 0..60 {
            let (a, b) = (Solid::new(&kind(&mut random)).0, Solid::new(&kind(&mut random)).0);
            let a_from_b = placement(&mut random);
            let mut sample = |solid: &Solid| -> Vec<DVec3> {
                let far = |random: &mut Random| {
                    let towards = random.in_cube().normalize();
                    solid.support(towards) + solid.round() * towards
                };
                (0..400).map(|_| far(&mut random).lerp(far(&mut random), random.unit())).collect()
            };
            let (of_a, of_b) = (sample(&a), sample(&b));
            let of_b: Vec<DVec3> =
                of_b.iter().map(|p| a_from_b.rotation * *p + a_from_b.translation).collect();
            let nearest =
                of_a.iter().flat_map(|p| of_b.iter().map(|q| p.distance(*q))).fold(f64::MAX, f64::min);
            let found = distance(&a, &b, &a_from_b, f64::INFINITY);
            assert!(found <= nearest + 1e-9, "{found}, {nearest}");
            assert!(a.outside(a_from_b.translation) <= a_from_b.translation.length());
        }
    }

    #[test]
    fn known_distances() {
        let (ball, cube) = (Solid::new(&ShapeKind::Sphere(0.5)).0, Solid::cube(0.5));
        let at = |x: f64, y: f64| Placement::from(Pose::new(DQuat::IDENTITY, DVec3::new(x, y, 0.0)).unwrap());
        assert!((distance(&ball, &cube, &at(3.0, 0.0), 9.0) - 2.0).abs() < 1e-3);
        assert!((distance(&cube, &cube, &at(1.5, 1.5), 9.0) - 0.5_f64.sqrt()).abs() < 1e-4);
        assert_eq!(distance(&cube, &cube, &at(0.9, 0.9), 9.0), 0.0);
        assert_eq!(distance(&ball, &ball, &at(0.0, 0.0), 9.0), 0.0);
        assert!(distance(&ball, &cube, &at(30.0, 0.0), 0.1) >= 0.1);
    }
}
