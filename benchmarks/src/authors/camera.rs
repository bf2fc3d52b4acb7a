use crate::Outcome;
use glam::{DMat3, DQuat, DVec3};
use nextview::geometry::Pose;

/// Returns the pose at `position` that looks at `target`, rolled to bring the tip of its y axis, one metre
/// long, as near as possible to that of the previous camera.
///
/// Found by fitting: the rays of the recorded first plan are rolled like this, except where the viewing
/// direction and the path between the tips are perpendicular to within 15 degrees. There the program's roll
/// is up to 20 degrees off either way, and no rule was found.
pub fn look_from(position: DVec3, target: DVec3, before: &Pose) -> Outcome<Pose> {
    let forward = (target - position).try_normalize();
    let forward = forward.ok_or_else(|| format!("a view at {position} is where it should look"))?;
    let tip = before.translation() + before.rotation() * DVec3::Y;
    let to_tip = tip - target;
    let down = (to_tip - forward * to_tip.dot(forward)).try_normalize();
    let down = down.unwrap_or_else(|| forward.any_orthonormal_vector());
    let axes = DMat3::from_cols(down.cross(forward), down, forward);
    Ok(Pose::new(DQuat::from_mat3(&axes), position)?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn looks_at_the_target_with_the_y_axis_of_the_camera_before() {
        let pose = look_from(DVec3::new(-0.3, 0.0, 0.1), DVec3::new(0.0, 0.0, 0.1), &Pose::IDENTITY).unwrap();
        assert!((pose.rotation() * DVec3::Z).distance(DVec3::X) < 1e-12);
        assert!((pose.rotation() * DVec3::Y).dot(DVec3::Y) > 0.99);
    }
}
