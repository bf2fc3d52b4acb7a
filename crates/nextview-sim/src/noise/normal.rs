use nextview::geometry::random::Random;
use std::f64::consts::TAU;

/// A number of the standard normal distribution (Box & Muller 1958).
pub(super) fn normal(random: &mut Random) -> f64 {
    let radius = (-2.0 * (1.0 - random.unit()).ln()).sqrt(); // 1 - u, so that it is never the logarithm of 0
    radius * (TAU * random.unit()).cos()
}
