use super::model::{JointMotion, ModelJoint};
use super::reader::{UrdfReader, children, shortened};
use crate::{JointKind, JointLimits};
use glam::DVec3;
use roxmltree::Node;
use std::f64::consts::TAU;

/// Minimum length of an axis to have a direction.
const SHORTEST_AXIS: f64 = 1e-9;

impl UrdfReader<'_> {
    pub fn joint(&mut self, node: Node) -> ModelJoint {
        let name = self.text(node, "name", "joint");
        let place = format!("joint {name:?}");
        ModelJoint {
            parent: self.end(node, "parent", &place),
            child: self.end(node, "child", &place),
            parent_from_joint: self.origin(node, &place),
            motion: self.motion(node, &place),
            line: self.line(node),
            name,
        }
    }

    /// The name of the link on one side of a joint.
    fn end(&mut self, node: Node, side: &'static str, place: &str) -> String {
        match children(node, side).next() {
            Some(end) => self.text(end, "link", &format!("{place}, {side}")),
            None => {
                self.add(node, place, format!("<{side}> is missing, expected the name of a link"));
                String::new()
            }
        }
    }

    fn motion(&mut self, node: Node, place: &str) -> JointMotion {
        if children(node, "mimic").next().is_some() {
            return JointMotion::Unsupported("mimic");
        }
        match node.attribute("type") {
            Some("fixed") => JointMotion::Fixed,
            Some("floating") => JointMotion::Unsupported("floating"),
            Some("planar") => JointMotion::Unsupported("planar"),
            Some("revolute") => self.moves(node, place, JointKind::Revolute, false),
            Some("continuous") => self.moves(node, place, JointKind::Revolute, true),
            Some("prismatic") => self.moves(node, place, JointKind::Prismatic, false),
            other => {
                let found = shortened(other.unwrap_or_default());
                let expected = "expected revolute, continuous, prismatic, fixed, floating or planar";
                self.add(node, place, format!("`type` is {found:?}, {expected}"));
                JointMotion::Fixed
            }
        }
    }

    fn moves(&mut self, node: Node, place: &str, kind: JointKind, is_continuous: bool) -> JointMotion {
        JointMotion::Moves {
            kind,
            axis: self.axis(node, place),
            limits: self.limits(node, place, is_continuous),
        }
    }

    /// The direction of the axis; by default x, as the format defines.
    fn axis(&mut self, node: Node, place: &str) -> DVec3 {
        let Some(axis) = children(node, "axis").next() else { return DVec3::X };
        let place = format!("{place}, axis");
        let Some(numbers) = self.numbers(axis, "xyz", &place, Some([1.0, 0.0, 0.0])) else { return DVec3::X };
        let direction = DVec3::from(numbers);
        if direction.length() < SHORTEST_AXIS {
            let found = shortened(axis.attribute("xyz").unwrap_or_default());
            self.add(axis, place, format!("`xyz` is {found:?}, expected a direction"));
            return DVec3::X;
        }
        direction.normalize()
    }

    fn limits(&mut self, node: Node, place: &str, is_continuous: bool) -> JointLimits {
        let harmless = JointLimits { lower: 0.0, upper: 0.0, velocity: 1.0, acceleration: 1.0 };
        let Some(limit) = children(node, "limit").next() else {
            let expected = if is_continuous { "`velocity`" } else { "`lower`, `upper` and `velocity`" };
            self.add(node, place, format!("<limit> is missing, expected one with {expected}"));
            return harmless;
        };
        let place = format!("{place}, limit");
        let [lower, upper] = match is_continuous {
            true => [Some([-TAU]), Some([TAU])],
            false => ["lower", "upper"].map(|side| self.numbers(limit, side, &place, None)),
        };
        let velocity = self.numbers(limit, "velocity", &place, None);
        let (Some([lower]), Some([upper]), Some([velocity])) = (lower, upper, velocity) else {
            return harmless;
        };
        if lower > upper {
            self.add(limit, &place, format!("`lower` is {lower}, expected at most `upper`, {upper}"));
        }
        if velocity <= 0.0 {
            self.add(limit, &place, format!("`velocity` is {velocity}, expected a positive number"));
        }
        let acceleration = velocity / self.options.seconds_to_full_speed;
        JointLimits { lower, upper, velocity, acceleration }
    }
}
