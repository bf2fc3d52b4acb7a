//! Prior knowledge of camera poses: the given ones, their errors, and an error that all of them share.

use super::{GivenPoses, RegistrationConfig};
use crate::geometry::Pose;
use glam::DVec3;

/// Deviation of a given pose's own error, and of the error that all given poses share, as shares of the
/// [uncertainty](RegistrationConfig), which is their maximum. By default 5 mm and 1 degree, 10 mm and 2
/// degrees.
const OWN: f64 = 0.1;
const SHARED: f64 = 0.2;

/// Deviation of what has no error, as a share of that of what has one.
const EXACT: f64 = 1e-4;

/// Standard deviations of a pose per axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct PoseDeviation {
    /// Metres.
    pub position: f64,
    /// Radians.
    pub rotation: f64,
}

/// The prior of all poses: `world_from_camera = world_from_given * given_from_camera * own_error`.
///
/// A robot knows where its flange is; if the calibration of the camera on it is wrong, it is wrong in the
/// same way in all frames. Such an error is one unknown, not one per frame.
#[derive(Clone, Copy, Debug)]
pub(super) struct PosePrior {
    /// Of the own error of a pose.
    own: PoseDeviation,
    /// Of `given_from_camera`, whose mean is the identity.
    pub shared: PoseDeviation,
    /// Whether the first pose is exact: it then has neither error.
    is_first_exact: bool,
    /// The error that all given poses share: of a camera on a robot, the hand-eye error.
    pub given_from_camera: Pose,
}

impl PosePrior {
    /// Returns the prior that this configuration describes, with no error yet.
    pub fn new(config: &RegistrationConfig) -> Self {
        let share_of = |share: f64| PoseDeviation {
            position: share * config.position_uncertainty,
            rotation: share * config.rotation_uncertainty,
        };
        // Poses found by alignment have no error in common.
        let shared = if config.given_poses == GivenPoses::Tracked { EXACT } else { SHARED };
        Self {
            own: share_of(OWN),
            shared: share_of(shared),
            is_first_exact: config.given_poses != GivenPoses::Independent,
            given_from_camera: Pose::IDENTITY,
        }
    }

    /// Whether the pose of a view is exact.
    pub fn is_exact(&self, view: usize) -> bool {
        self.is_first_exact && view == 0
    }

    /// Returns the mean of the pose of a view, whose given pose is this one.
    pub fn mean(&self, view: usize, given: &Pose) -> Pose {
        if self.is_exact(view) { *given } else { *given * self.given_from_camera }
    }

    /// Returns the deviation of the pose of a view from its mean.
    pub fn deviation(&self, view: usize) -> PoseDeviation {
        let share = if self.is_exact(view) { EXACT } else { 1.0 };
        PoseDeviation { position: share * self.own.position, rotation: share * self.own.rotation }
    }
}

/// Returns the motion that a pose still has to make to another one, in its own frame: a rotation vector,
/// radians, and a translation, metres.
pub(super) fn difference(from: &Pose, to: &Pose) -> [DVec3; 2] {
    let motion = from.inverse() * *to;
    let rotation = motion.rotation();
    // A rotation has two quaternions; this is the shorter one.
    [(if rotation.w < 0.0 { -rotation } else { rotation }).to_scaled_axis(), motion.translation()]
}
