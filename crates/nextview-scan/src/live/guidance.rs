use nextview::geometry::Pose;
use serde::Serialize;

/// The motion from a hand-held camera to the wanted view.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Guidance {
    /// From the camera to the wanted position, in the camera frame: right, down, forward.
    pub arrow_m: [f64; 3],
    /// Length of the arrow.
    pub distance_m: f64,
    /// The turn to the right, -180..=180, then down, -90..=90, that aligns the camera with the wanted axis.
    pub turn_deg: [f64; 2],
    /// The angle between the camera's actual and wanted viewing directions, 0..=180.
    pub angle_deg: f64,
    /// Whether the camera is near enough: the image would show nearly the same.
    pub reached: bool,
}

/// Maximum offset of a camera that is near enough, as a share of its viewing distance.
const NEAR: f64 = 0.1;

/// Maximum angle, in degrees, by which a camera that is near enough looks past the wanted point.
const NEAR_ANGLE: f64 = 10.0;

impl Guidance {
    /// Guides the camera to the wanted pose, which looks at something at a distance in metres. Rotation about
    /// the optical axis is ignored.
    pub(super) fn to(wanted: &Pose, world_from_camera: &Pose, distance: f64) -> Self {
        let camera_from_wanted = world_from_camera.inverse() * *wanted;
        let arrow = camera_from_wanted.translation();
        let axis = camera_from_wanted.rotation() * glam::DVec3::Z;
        let angle_deg = axis.truncate().length().atan2(axis.z).to_degrees();
        let [right, down] = [axis.x.atan2(axis.z), axis.y.atan2(axis.x.hypot(axis.z))];
        Self {
            arrow_m: arrow.to_array(),
            distance_m: arrow.length(),
            turn_deg: [right.to_degrees(), down.to_degrees()],
            angle_deg,
            reached: arrow.length() <= NEAR * distance && angle_deg <= NEAR_ANGLE,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{DQuat, DVec3};
    use nextview::view::look_at;

    #[test]
    fn the_arrow_leads_to_the_view() {
        let wanted = look_at(DVec3::new(0.4, 0.1, 0.2), DVec3::ZERO).unwrap();
        let turn = DQuat::from_rotation_x(0.3) * DQuat::from_rotation_z(1.0);
        let camera = Pose::new(turn, DVec3::new(-0.2, 0.5, 0.1)).unwrap();
        let guidance = Guidance::to(&wanted, &camera, 0.5);
        let there = camera.transform_point(DVec3::from_array(guidance.arrow_m));
        assert!(there.distance(wanted.translation()) < 1e-12 && !guidance.reached);
        // After the turn, the camera looks along the wanted axis.
        let [right, down] = guidance.turn_deg.map(f64::to_radians);
        let turned = camera.rotation() * DQuat::from_rotation_y(right) * DQuat::from_rotation_x(-down);
        assert!((turned * DVec3::Z).distance(wanted.rotation() * DVec3::Z) < 1e-12);
    }

    #[test]
    fn near_is_a_share_of_the_distance_and_a_roll_does_not_matter() {
        let wanted = look_at(DVec3::X, DVec3::ZERO).unwrap();
        let at = |shift: f64, tilt: f64| {
            let turn = wanted.rotation() * DQuat::from_rotation_z(2.0) * DQuat::from_rotation_x(tilt);
            Guidance::to(&wanted, &Pose::new(turn, wanted.translation() + shift * DVec3::Y).unwrap(), 1.0)
        };
        assert!(at(0.0, 0.0).reached && at(0.09, 0.1).reached);
        assert!(!at(0.11, 0.0).reached && !at(0.0, 0.2).reached);
        assert!(at(0.0, 0.0).angle_deg < 1e-6 && (at(0.0, 3.0).angle_deg - 3_f64.to_degrees()).abs() < 1e-9);
    }
}
