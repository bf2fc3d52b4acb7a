use super::Mount;
use crate::collision::{Attachment, CellError, Checker, Obstacle};
use crate::{Arm, Joint, JointKind};
use glam::{DQuat, DVec3};
use nextview::geometry::Pose;
use nextview::view::Reachability;
use std::collections::HashMap;
use std::f64::consts::{FRAC_PI_4, TAU};

/// An arm with its pose, its load and its declared obstacles.
#[derive(Clone, Debug)]
pub struct RobotCell {
    mount: Mount,
    attached: Vec<Attachment>,
    obstacles: Vec<Obstacle>,
    clearance_m: f64,
    /// Checks against the declared obstacles only.
    checker: Checker,
}

/// Possible rotations of a camera about its optical axis, in eighths of a turn, in order of preference.
const ROLLS: [i32; 8] = [0, 1, -1, 2, -2, 3, -3, 4];

impl RobotCell {
    /// Creates a cell of this arm; obstacles are in the frame of its base. Fails like [`Checker::new`].
    pub fn new(
        arm: Arm,
        mount: Mount,
        attached: Vec<Attachment>,
        obstacles: Vec<Obstacle>,
        clearance_m: f64,
    ) -> Result<Self, CellError> {
        let checker = Checker::new(arm, attached.clone(), obstacles.clone(), clearance_m)?;
        Ok(Self { mount, attached, obstacles, clearance_m, checker })
    }

    /// The arm.
    pub fn arm(&self) -> &Arm {
        self.checker.arm()
    }

    /// The load of the flange.
    pub fn mount(&self) -> &Mount {
        &self.mount
    }

    /// Returns the camera pose, relative to the object, at these joint values.
    ///
    /// # Panics
    ///
    /// If the number of values is not that of joints.
    pub fn world_from_camera(&self, values: &[f64]) -> Pose {
        self.mount.world_from_camera(self.arm(), values)
    }

    /// All joint values that put the camera at this pose without a collision of the arm with itself or a
    /// declared obstacle.
    pub fn solutions(&self, world_from_camera: &Pose) -> Vec<Vec<f64>> {
        self.free_solutions(world_from_camera, &self.checker)
    }

    /// As [`solutions`](Self::solutions), but without contact in this checker.
    pub fn free_solutions(&self, world_from_camera: &Pose, checker: &Checker) -> Vec<Vec<f64>> {
        let mut solutions = self.arm().inverse(&self.mount.base_from_flange(world_from_camera));
        // Full turns of joints give dozens of solutions that occupy the same space.
        let mut known: HashMap<Vec<i64>, bool> = HashMap::new();
        solutions.retain(|values| {
            *known.entry(self.turned_back(values)).or_insert_with(|| checker.contact(values).is_none())
        });
        solutions
    }

    /// Joint values without full turns, in billionths of a turn or, for sliding joints, of a metre.
    fn turned_back(&self, values: &[f64]) -> Vec<i64> {
        let within_turn = |(joint, value): (&Joint, &f64)| match joint.kind {
            JointKind::Revolute => ((value / TAU).rem_euclid(1.0) * 1e9).round() as i64 % 1_000_000_000,
            JointKind::Prismatic => (value * 1e9).round() as i64,
        };
        self.arm().joints.iter().zip(values).map(within_turn).collect()
    }

    /// Extends the checker of the cell with obstacles and attachments measured by a scan.
    pub fn checker_with(
        &self,
        attached: impl IntoIterator<Item = Attachment>,
        obstacles: impl IntoIterator<Item = Obstacle>,
    ) -> Result<Checker, CellError> {
        let attached = self.attached.iter().cloned().chain(attached).collect();
        let obstacles = self.obstacles.iter().cloned().chain(obstacles).collect();
        Checker::new(self.arm().clone(), attached, obstacles, self.clearance_m)
    }
}

impl Reachability for RobotCell {
    /// The pose, rotated about the optical axis as little as possible, for which there are
    /// [solutions](RobotCell::solutions).
    fn held(&self, world_from_camera: &Pose) -> Option<Pose> {
        ROLLS
            .into_iter()
            .map(|eighths| rolled(world_from_camera, eighths))
            .find(|pose| !self.solutions(pose).is_empty())
    }
}

fn rolled(world_from_camera: &Pose, eighths: i32) -> Pose {
    if eighths == 0 {
        return *world_from_camera;
    }
    let turn = Pose::new(DQuat::from_rotation_z(f64::from(eighths) * FRAC_PI_4), DVec3::ZERO);
    *world_from_camera * turn.expect("a turn about an axis is a rotation")
}
