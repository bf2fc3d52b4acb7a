//! Prior knowledge of camera poses: the given ones, their errors, and an error that all of them share.

use super::{GivenPoses, RegistrationConfig};
use crate::geometry::Pose;
use glam::DVec3;

/// Deviation of a given pose's own error before frames have shown it, and of the error that all given poses
/// share, as shares of the [uncertainty](RegistrationConfig), which is their maximum. By default 5 mm and 1
/// degree, 10 mm and 2 degrees.
const OWN: f64 = 0.1;
const SHARED: f64 = 0.2;

/// Range of the deviation of given poses' own errors that frames may show, as shares of the uncertainty. By
/// default 0.1 to 17 mm, and 0.02 to 3.3 degrees.
const LEAST_OWN: f64 = 0.002;
const MOST_OWN: f64 = 1.0 / 3.0;

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

impl PoseDeviation {
    fn times(&self, factor: f64) -> Self {
        Self { position: factor * self.position, rotation: factor * self.rotation }
    }
}

/// The prior of all poses: `world_from_camera = world_from_given * given_from_camera * own_error`.
///
/// A robot knows where its flange is; if the calibration of the camera on it is wrong, it is wrong in the
/// same way in all frames. Such an error is one unknown, not one per frame.
#[derive(Clone, Copy, Debug)]
pub(super) struct PosePrior {
    /// Of the own error of a pose.
    own: PoseDeviation,
    /// The largest error of a pose.
    uncertainty: PoseDeviation,
    /// Of `given_from_camera`, whose mean is the identity.
    pub shared: PoseDeviation,
    /// Whether the given poses may share an error; those found by alignment do not.
    pub may_share_error: bool,
    /// Whether the first pose is exact: it then has neither error.
    is_first_exact: bool,
    /// The error that all given poses share: of a camera on a robot, the hand-eye error.
    pub given_from_camera: Pose,
}

impl PosePrior {
    /// Returns the prior that this configuration describes, with no error yet.
    pub fn new(config: &RegistrationConfig) -> Self {
        let uncertainty =
            PoseDeviation { position: config.position_uncertainty, rotation: config.rotation_uncertainty };
        let may_share_error = config.given_poses != GivenPoses::Tracked;
        Self {
            own: uncertainty.times(OWN),
            uncertainty,
            shared: uncertainty.times(if may_share_error { SHARED } else { EXACT }),
            may_share_error,
            is_first_exact: config.given_poses != GivenPoses::Independent,
            given_from_camera: Pose::IDENTITY,
        }
    }

    /// Returns the prior of poses that share no error, before frames have shown the deviation of their own
    /// ones.
    pub fn without_shared_error(&self) -> Self {
        Self {
            own: self.uncertainty.times(OWN),
            shared: self.uncertainty.times(EXACT),
            may_share_error: false,
            given_from_camera: Pose::IDENTITY,
            ..*self
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
        self.own.times(if self.is_exact(view) { EXACT } else { 1.0 })
    }

    /// Adopts the deviation of the poses' own errors that frames have shown. Returns its largest change, as a
    /// share of what it was.
    pub fn adopt_own(&mut self, shown: PoseDeviation) -> f64 {
        let clamp = |shown: f64, most: f64| shown.clamp(LEAST_OWN * most, MOST_OWN * most);
        let before = self.own;
        self.own = PoseDeviation {
            position: clamp(shown.position, self.uncertainty.position),
            rotation: clamp(shown.rotation, self.uncertainty.rotation),
        };
        let change = |now: f64, before: f64| (now / before - 1.0).abs();
        change(self.own.position, before.position).max(change(self.own.rotation, before.rotation))
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
