use crate::Arm;
use nextview::geometry::Pose;

/// The load of an arm's flange, and the poses of everything else. The object does not move in the world
/// frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Mount {
    /// The flange carries the camera.
    Camera {
        /// Pose of the arm's base.
        world_from_base: Pose,
        /// The hand-eye matrix.
        flange_from_camera: Pose,
    },
    /// The flange carries the object in front of a fixed camera.
    Object {
        /// Pose on the flange of the object, and so of the world.
        flange_from_world: Pose,
        /// Pose of the camera.
        base_from_camera: Pose,
    },
}

impl Mount {
    /// Returns the flange pose that puts the camera at this pose.
    pub fn base_from_flange(&self, world_from_camera: &Pose) -> Pose {
        match self {
            Self::Camera { world_from_base, flange_from_camera } => {
                world_from_base.inverse() * *world_from_camera * flange_from_camera.inverse()
            }
            Self::Object { flange_from_world, base_from_camera } => {
                *base_from_camera * world_from_camera.inverse() * flange_from_world.inverse()
            }
        }
    }

    /// Returns the camera pose, relative to the object, at these joint values.
    ///
    /// # Panics
    ///
    /// If the number of values is not that of joints.
    pub fn world_from_camera(&self, arm: &Arm, values: &[f64]) -> Pose {
        let base_from_flange = arm.forward(values);
        match self {
            Self::Camera { world_from_base, flange_from_camera } => {
                *world_from_base * base_from_flange * *flange_from_camera
            }
            Self::Object { flange_from_world, base_from_camera } => {
                flange_from_world.inverse() * base_from_flange.inverse() * *base_from_camera
            }
        }
    }
}
