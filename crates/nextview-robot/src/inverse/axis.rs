use crate::{Arm, JointKind};
use glam::{DQuat, DVec3};
use nextview::geometry::Pose;

/// Maximum angle between parallel axes in radians.
const PARALLEL: f64 = 0.01;
/// Maximum distance between meeting axes in metres.
const MEETING: f64 = 0.005;

/// The axis of a turning joint in the frame of the base, with all joints at 0.
#[derive(Clone, Copy)]
pub(super) struct JointAxis {
    /// Unit vector.
    pub direction: DVec3,
    pub point: DVec3,
}

impl JointAxis {
    pub fn rotation(&self, angle: f64) -> DQuat {
        DQuat::from_axis_angle(self.direction, angle)
    }

    /// Turns a point about the axis.
    pub fn turned(&self, angle: f64, point: DVec3) -> DVec3 {
        self.point + self.rotation(angle) * (point - self.point)
    }

    /// Rotation about the axis as a transform.
    pub fn motion(&self, angle: f64) -> Pose {
        let rotation = self.rotation(angle);
        Pose::new(rotation, self.point - rotation * self.point).expect("axes of an arm are within reach")
    }

    /// The axis in the opposite direction.
    pub fn reversed(&self) -> Self {
        Self { direction: -self.direction, point: self.point }
    }

    pub fn is_parallel(&self, other: &Self) -> bool {
        self.direction.cross(other.direction).length() < PARALLEL
    }

    /// The point where two axes meet, if they do.
    pub fn meets(&self, other: &Self) -> Option<DVec3> {
        if self.is_parallel(other) {
            return None;
        }
        let normal = self.direction.cross(other.direction);
        let between = other.point - self.point;
        let along = between.cross(other.direction).dot(normal) / normal.length_squared();
        let nearest = self.point + along * self.direction;
        let gap = between.dot(normal.normalize());
        (gap.abs() < MEETING).then_some(nearest + gap / 2.0 * normal.normalize())
    }

    pub fn passes(&self, point: DVec3) -> bool {
        self.direction.cross(point - self.point).length() < MEETING
    }
}

/// Six turning axes and the pose of the flange with all of them at 0.
pub(super) struct SixAxes {
    pub axes: [JointAxis; 6],
    pub base_from_flange: Pose,
}

impl SixAxes {
    /// The axes of an arm with six joints, or with seven if one is held at a value; `None` if any slides.
    pub fn of(arm: &Arm, held: Option<(usize, f64)>) -> Option<Self> {
        let mut values = vec![0.0; arm.n_joints()];
        if let Some((joint, value)) = held {
            values[joint] = value;
        }
        let base_from_links = arm.link_poses(&values);
        let free = (0..arm.n_joints()).filter(|joint| held.is_none_or(|held| held.0 != *joint));
        let axes = free.map(|number| {
            let joint = &arm.joints[number];
            let base_from_joint = base_from_links[number] * joint.parent_from_joint;
            let direction = (base_from_joint.rotation() * joint.axis).normalize();
            let axis = JointAxis { direction, point: base_from_joint.translation() };
            (joint.kind == JointKind::Revolute).then_some(axis)
        });
        let axes: [JointAxis; 6] = axes.collect::<Option<Vec<_>>>()?.try_into().ok()?;
        Some(Self { axes, base_from_flange: base_from_links[arm.n_joints()] * arm.last_link_from_flange })
    }
}
