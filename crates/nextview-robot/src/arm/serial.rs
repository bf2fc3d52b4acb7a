use super::{Joint, Link};
use nextview::geometry::Pose;

/// A serial arm: a base, moving joints, the links between them, and a flange for tools. Link 0 is the base,
/// whose frame is that of the arm; link i + 1 moves with joint i. Parts connected by a fixed joint are one
/// link.
#[derive(Clone, Debug, PartialEq)]
pub struct Arm {
    /// Name of the robot.
    pub name: String,
    /// The joints from the base to the flange.
    pub joints: Vec<Joint>,
    /// The links: one more than there are joints.
    pub links: Vec<Link>,
    /// The frame of the flange in that of the last link. Tools and cameras are mounted on it.
    pub last_link_from_flange: Pose,
    /// Pairs of links, lower number first, that may touch, for example neighbours.
    pub may_touch: Vec<[usize; 2]>,
}

impl Arm {
    /// Number of joints.
    pub fn n_joints(&self) -> usize {
        self.joints.len()
    }

    /// Returns the frames of all links in that of the base, `base_from_link`: one more than there are joints.
    ///
    /// # Panics
    ///
    /// If the number of values is not that of joints.
    pub fn link_poses(&self, values: &[f64]) -> Vec<Pose> {
        assert_eq!(values.len(), self.joints.len(), "a value for each joint");
        let mut poses = Vec::with_capacity(self.links.len());
        let mut base_from_link = Pose::IDENTITY;
        poses.push(base_from_link);
        for (joint, &value) in self.joints.iter().zip(values) {
            base_from_link = base_from_link * joint.parent_from_child(value);
            poses.push(base_from_link);
        }
        poses
    }

    /// Returns the pose of the flange: `base_from_flange`.
    ///
    /// # Panics
    ///
    /// If the number of values is not that of joints.
    pub fn forward(&self, values: &[f64]) -> Pose {
        assert_eq!(values.len(), self.joints.len(), "a value for each joint");
        let step = |pose: Pose, (joint, &value): (&Joint, &f64)| pose * joint.parent_from_child(value);
        self.joints.iter().zip(values).fold(Pose::IDENTITY, step) * self.last_link_from_flange
    }

    /// Whether every value is within its joint's limits.
    pub fn is_within_limits(&self, values: &[f64]) -> bool {
        self.joints.iter().zip(values).all(|(joint, value)| joint.limits.contains(*value))
    }
}
