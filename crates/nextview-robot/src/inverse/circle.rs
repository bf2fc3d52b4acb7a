//! Angles of rotation about an axis that bring a vector to a target: the building blocks of closed forms.

use glam::{DQuat, DVec3};

/// Vectors with a shorter product, in metres or metres squared, determine no angle.
const SINGULAR: f64 = 1e-7;
/// Maximum miss of a target, as a share of the circle's radius, that counts as touching. A pose at the border
/// of the reachable space is found despite rounding and slightly misaligned axes. Newton steps and a test of
/// every solution follow.
const TOUCHED: f64 = 1e-2;

/// Angles about the unit vector `axis` at which the product of the turned `vector` with `other` is `product`:
/// none or two (equal if the circle is touched). If every angle is a solution, the angles in `free`.
pub(super) fn angles_to_product(
    axis: DVec3,
    vector: DVec3,
    other: DVec3,
    product: f64,
    free: &[f64],
) -> Vec<f64> {
    let along = axis * axis.dot(vector);
    let (cosine, sine) = ((vector - along).dot(other), axis.cross(vector).dot(other));
    let (radius, rest) = (cosine.hypot(sine), product - along.dot(other));
    if radius < SINGULAR {
        return if rest.abs() < SINGULAR { free.to_vec() } else { Vec::new() };
    }
    let ratio = rest / radius;
    if ratio.abs() > 1.0 + TOUCHED {
        return Vec::new();
    }
    let (middle, half) = (sine.atan2(cosine), ratio.clamp(-1.0, 1.0).acos());
    vec![middle - half, middle + half]
}

/// Angles about an axis through `center` at which the turned `point` has this distance from `target`.
pub(super) fn angles_to_distance(
    axis: DVec3,
    center: DVec3,
    point: DVec3,
    target: DVec3,
    distance: f64,
    free: &[f64],
) -> Vec<f64> {
    let (arm, other) = (point - center, target - center);
    let product = (arm.length_squared() + other.length_squared() - distance * distance) / 2.0;
    angles_to_product(axis, arm, other, product, free)
}

/// The angle about the unit vector `axis` that turns `from` into the half-plane of `to`; the angles in `free`
/// if either vector is along the axis.
pub(super) fn angles_between(axis: DVec3, from: DVec3, to: DVec3, free: &[f64]) -> Vec<f64> {
    let flat = |vector: DVec3| vector - axis * axis.dot(vector);
    let (from, to) = (flat(from), flat(to));
    if from.length().min(to.length()) < SINGULAR {
        return free.to_vec();
    }
    vec![axis.dot(from.cross(to)).atan2(from.dot(to))]
}

/// The angle of a rotation about an axis, from the image of one vector.
pub(super) fn angle_of(axis: DVec3, rotation: DQuat) -> f64 {
    let from = axis.any_orthonormal_vector();
    let to = rotation * from;
    axis.dot(from.cross(to)).atan2(from.dot(to))
}
