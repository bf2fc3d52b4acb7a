//! Interpolation between two numbers.

/// The number at this share (0 to 1) of the way from `a` to `b`.
pub(super) fn mix(a: f64, b: f64, share: f64) -> f64 {
    a * (1.0 - share) + b * share
}

/// The number at this share with a slow start and end, so a chain of them has no corners.
pub(super) fn eased_mix(a: f64, b: f64, share: f64) -> f64 {
    mix(a, b, share * share * (3.0 - 2.0 * share))
}
