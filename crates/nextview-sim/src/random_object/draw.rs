//! Random values for several kinds of part.

use glam::{DMat3, DQuat};
use nextview::geometry::random::Random;
use std::f64::consts::FRAC_PI_2;

/// True with this probability.
pub(super) fn chance(random: &mut Random, share: f64) -> bool {
    random.unit() < share
}

/// A rotation, uniformly distributed: a direction in four dimensions, from the points of the ball (Marsaglia
/// 1972).
pub(super) fn rotation(random: &mut Random) -> DMat3 {
    loop {
        let inside = DQuat::from_array([(); 4].map(|()| random.range(-1.0, 1.0)));
        if (0.01..1.0).contains(&inside.length_squared()) {
            return DMat3::from_quat(inside.normalize());
        }
    }
}

/// A rotation that brings the z axis along one of the three axes.
pub(super) fn upright(random: &mut Random) -> DMat3 {
    let turns = [DMat3::IDENTITY, DMat3::from_rotation_x(FRAC_PI_2), DMat3::from_rotation_y(FRAC_PI_2)];
    turns[random.index(3)]
}
