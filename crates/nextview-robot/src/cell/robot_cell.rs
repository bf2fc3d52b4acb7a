use super::Mount;
use crate::collision::{Attachment, CellError, Checker, Obstacle};
use crate::{Arm, Joint, JointKind};
use glam::{DQuat, DVec3};
use nextview::geometry::Pose;
use nextview::view::Reachability;
use std::collections::HashMap;
use std::f64::consts::{FRAC_PI_4, TAU};

/// An arm where it stands, with what it carries and what is declared to be around it.
#[derive(Clone, Debug)]
pub struct RobotCell {
    mount: Mount,
    attached: Vec<Attachment>,
    obstacles: Vec<Obstacle>,
    clearance_m: f64,
    /// Of the declared obstacles alone.
    checker: Checker,
}

/// Angles by which a camera may be turned about its optical axis, in eighths of a turn, in order of
/// preference.
const ROLLS: [i32; 8] = [0, 1, -1, 2, -2, 3, -3, 4];

impl RobotCell {
    /// A cell of this arm; obstacles are in the frame of its base. Fails as [`Checker::new`].
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

    /// Where the camera is, seen from the object, with these joint values.
    ///
    /// # Panics
    ///
    /// If there are not as many values as joints.
    pub fn world_from_camera(&self, values: &[f64]) -> Pose {
        self.mount.world_from_camera(self.arm(), values)
    }

    /// All joint values with which the camera is there, and the arm touches neither itself nor anything that
    /// is declared to be around it.
    pub fn solutions(&self, world_from_camera: &Pose) -> Vec<Vec<f64>> {
        self.free_solutions(world_from_camera, &self.checker)
    }

    /// The same where nothing of this checker is touched.
    pub fn free_solutions(&self, world_from_camera: &Pose, checker: &Checker) -> Vec<Vec<f64>> {
        let mut solutions = self.arm().inverse(&self.mount.base_from_flange(world_from_camera));
        // Whole turns of joints make dozens of solutions that take up the same space.
        let mut known: HashMap<Vec<i64>, bool> = HashMap::new();
        solutions.retain(|values| {
            *known.entry(self.turned_back(values)).or_insert_with(|| checker.contact(values).is_none())
        });
        solutions
    }

    /// Joint values but for whole turns, in billionths.
    fn turned_back(&self, values: &[f64]) -> Vec<i64> {
        let within_turn = |(joint, value): (&Joint, &f64)| match joint.kind {
            JointKind::Revolute => ((value / TAU).rem_euclid(1.0) * 1e9).round() as i64 % 1_000_000_000,
            JointKind::Prismatic => (value * 1e9).round() as i64,
        };
        self.arm().joints.iter().zip(values).map(within_turn).collect()
    }

    /// The checker of the cell with more around the arm and more on its flange: what a scan has measured.
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
    /// The pose, or one turned about the optical axis, for which there are [solutions](RobotCell::solutions):
    /// turned as little as possible.
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
