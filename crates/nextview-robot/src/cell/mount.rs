use crate::Arm;
use nextview::geometry::Pose;

/// The load of an arm's flange, and the poses of everything else. The world is where the object does not
/// move.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Mount {
    /// The flange carries the camera.
    Camera {
        /// Where the base of the arm stands.
        world_from_base: Pose,
        /// The hand-eye matrix.
        flange_from_camera: Pose,
    },
    /// The flange carries the object, before a camera that stands still.
    Object {
        /// Where the object, and with it the world, is on the flange.
        flange_from_world: Pose,
        /// Where the camera stands.
        base_from_camera: Pose,
    },
}

impl Mount {
    /// Where the flange must be for the camera to be there.
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

    /// Where the camera is, seen from the object, with these joint values.
    ///
    /// # Panics
    ///
    /// If there are not as many values as joints.
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
