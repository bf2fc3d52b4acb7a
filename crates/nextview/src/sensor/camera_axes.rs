use crate::geometry::Pose;
use glam::{DMat3, DQuat, DVec3};
use serde::{Deserialize, Serialize};

/// Axis conventions of camera frames. This library uses OpenCV's.
///
/// ```
/// use glam::{DQuat, DVec3};
/// use nextview::geometry::Pose;
/// use nextview::sensor::CameraAxes;
///
/// // In Blender a camera without rotation looks down.
/// let pose = Pose::new(DQuat::IDENTITY, DVec3::Z).unwrap();
/// let world_from_camera = CameraAxes::OpenGl.to_opencv(&pose);
/// assert!((world_from_camera.rotation() * DVec3::Z - DVec3::NEG_Z).length() < 1e-12);
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "lowercase")]
#[non_exhaustive]
pub enum CameraAxes {
    /// x right, y down, z forward: OpenCV, ROS's optical frames, Open3D, COLMAP. The default.
    #[default]
    OpenCv,
    /// x right, y up, z backward: OpenGL, Blender, ARKit, instant-ngp.
    OpenGl,
    /// x forward, y left, z up: ROS's body frames.
    Ros,
}

impl CameraAxes {
    /// Converts the pose (`world_from_camera`) of a camera to OpenCV's axes.
    pub fn to_opencv(self, world_from_camera: &Pose) -> Pose {
        let camera_from_opencv = match self {
            Self::OpenCv => return *world_from_camera,
            Self::OpenGl => DMat3::from_diagonal(DVec3::new(1.0, -1.0, -1.0)),
            Self::Ros => DMat3::from_cols(-DVec3::Y, -DVec3::Z, DVec3::X),
        };
        let turned = world_from_camera.rotation() * DQuat::from_mat3(&camera_from_opencv);
        Pose::from_unit(turned.normalize(), world_from_camera.translation())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_axes_point_where_they_should() {
        let pose = Pose::new(DQuat::from_rotation_x(0.3), DVec3::new(0.1, 0.2, 0.3)).unwrap();
        // Right, down and forward in each convention's own axes.
        let conventions = [
            (CameraAxes::OpenCv, [DVec3::X, DVec3::Y, DVec3::Z]),
            (CameraAxes::OpenGl, [DVec3::X, -DVec3::Y, -DVec3::Z]),
            (CameraAxes::Ros, [-DVec3::Y, -DVec3::Z, DVec3::X]),
        ];
        for (axes, own) in conventions {
            let turned = axes.to_opencv(&pose);
            assert_eq!(turned.translation(), pose.translation());
            for (opencv, own) in DMat3::IDENTITY.to_cols_array_2d().map(DVec3::from).into_iter().zip(own) {
                let (seen, expected) = (turned.rotation() * opencv, pose.rotation() * own);
                assert!((seen - expected).length() < 1e-12, "{axes:?}: {seen} instead of {expected}");
            }
        }
    }
}
