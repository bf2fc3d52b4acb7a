use crate::Error;
use crate::geometry::{Pose, check_position};
use glam::{DMat3, DVec3};

/// Sine of the angle between viewing direction and vertical below which a view counts as vertical: the
/// horizon's direction would be rounding noise.
const VERTICAL: f64 = 1e-6;

/// Returns the pose of a camera at `position` that looks at `target`, both within [`Pose::REACH`].
///
/// Roll: the top of the image points up, so the image's x axis is horizontal. Looking straight down or up,
/// the top of the image points along the world's +y axis. At the target itself, the camera looks along the
/// world's +x axis.
///
/// ```
/// use glam::DVec3;
/// use nextview::view::look_at;
///
/// let world_from_camera = look_at(DVec3::new(0.5, 0.0, 0.0), DVec3::ZERO).unwrap();
/// assert!(world_from_camera.transform_point(DVec3::Z * 0.5).length() < 1e-15, "the target lies on the optical axis");
/// assert!((world_from_camera.rotation() * DVec3::Y).distance(-DVec3::Z) < 1e-15, "down in the image is down");
/// ```
pub fn look_at(position: DVec3, target: DVec3) -> Result<Pose, Error> {
    check_position("position", position)?;
    check_position("target", target)?;
    let forward = (target - position).try_normalize().unwrap_or(DVec3::X);
    let up = if forward.cross(DVec3::Z).length() < VERTICAL { DVec3::Y } else { DVec3::Z };
    let right = forward.cross(up).normalize();
    let down = forward.cross(right);
    Ok(Pose::from_basis(DMat3::from_cols(right, down, forward), position))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn looks_at_the_target_with_a_level_horizon(p in prop::array::uniform3(-2.0..2.0), t in prop::array::uniform3(-2.0..2.0)) {
            let (position, target) = (DVec3::from_array(p), DVec3::from_array(t));
            let pose = look_at(position, target).unwrap();
            let distance = position.distance(target);
            prop_assert!(pose.transform_point(DVec3::Z * distance).distance(target) < 1e-12);
            prop_assert!((pose.rotation() * DVec3::X).z.abs() < 1e-12);
            prop_assert!((pose.rotation() * DVec3::Y).z < 0.0);
        }
    }

    #[test]
    fn is_defined_straight_up_straight_down_and_nowhere() {
        let down = look_at(DVec3::Z, DVec3::ZERO).unwrap();
        assert!((down.rotation() * DVec3::Z).distance(-DVec3::Z) < 1e-15);
        assert!((down.rotation() * DVec3::Y).distance(-DVec3::Y) < 1e-15, "the top of the image is +y");
        let up = look_at(-DVec3::Z, DVec3::ZERO).unwrap();
        assert!((up.rotation() * DVec3::Y).distance(-DVec3::Y) < 1e-15);
        let nowhere = look_at(DVec3::ONE, DVec3::ONE).unwrap();
        assert!((nowhere.rotation() * DVec3::Z).distance(DVec3::X) < 1e-15);
    }

    #[test]
    fn refuses_what_is_no_place() {
        for bad in [f64::NAN, f64::INFINITY, 1e300, -1e9].map(|x| DVec3::new(0.0, x, 0.0)) {
            assert!(look_at(bad, DVec3::ZERO).unwrap_err().to_string().starts_with("position is "));
            assert!(look_at(DVec3::ZERO, bad).unwrap_err().to_string().starts_with("target is "));
        }
        assert!(look_at(DVec3::X * 1e8, DVec3::X).is_ok());
    }
}
