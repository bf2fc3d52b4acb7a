use super::error::{UrdfError, UrdfFault};
use super::model::{Model, ModelLink};
use super::options::UrdfOptions;
use glam::{DQuat, DVec3, EulerRot};
use nextview::geometry::Pose;
use roxmltree::{Document, Node};

/// Maximum number in a URDF: a thousand kilometres, which keeps all chains within [`Pose::REACH`].
pub(super) const LARGEST: f64 = 1e6;

/// Names of elements and attributes that are read inside a robot.
const NAMES: &str = "axis box child collision cylinder filename geometry joint length limit link lower \
    mesh mimic name origin parent radius rpy scale size sphere type upper velocity xyz";

/// Reads the elements of a URDF and collects their faults. An invalid value is replaced by a harmless one,
/// and reading continues.
pub(super) struct UrdfReader<'a> {
    pub options: &'a UrdfOptions<'a>,
    /// The offset at which each line begins.
    line_starts: Vec<usize>,
    faults: Vec<UrdfFault>,
}

impl<'a> UrdfReader<'a> {
    pub fn new(options: &'a UrdfOptions<'a>) -> Self {
        Self { options, line_starts: vec![0], faults: Vec::new() }
    }

    pub fn read(mut self, text: &str) -> Result<Model, UrdfError> {
        let document = Document::parse(text).map_err(|error| {
            let problem = format!("is not well-formed XML: {error}");
            UrdfFault::new(Some(error.pos().row), "URDF", problem)
        })?;
        self.line_starts.extend(text.match_indices('\n').map(|(at, _)| at + 1));
        let robot = document.root_element();
        if !robot.has_tag_name("robot") {
            let problem = format!("is <{}>, expected <robot>", robot.tag_name().name());
            self.add(robot, "root element", problem);
        }
        let of_xacro = |node: &Node| node.tag_name().namespace().is_some_and(|uri| uri.contains("xacro"));
        if let Some(node) = robot.descendants().find(of_xacro) {
            let problem = format!("<{}> is of xacro; expand the file first", node.tag_name().name());
            self.add(node, "URDF", problem);
        }
        self.check_case(robot);
        let seconds = self.options.seconds_to_full_speed;
        if !(seconds.is_finite() && seconds > 0.0) {
            let problem = format!("is {seconds}, expected a positive number of seconds");
            self.faults.push(UrdfFault::new(None, "seconds_to_full_speed", problem));
        }
        let model = Model {
            name: robot.attribute("name").unwrap_or("robot").to_owned(),
            links: children(robot, "link").map(|node| self.link(node)).collect(),
            joints: children(robot, "joint").map(|node| self.joint(node)).collect(),
        };
        match self.faults.is_empty() {
            true => Ok(model),
            false => Err(UrdfError { faults: self.faults }),
        }
    }

    /// Checks for names in the wrong case: XML is case-sensitive, so they would be skipped as unknown.
    fn check_case(&mut self, robot: Node) {
        let is_part = |node: &Node| {
            ["link", "joint"].iter().any(|part| node.tag_name().name().eq_ignore_ascii_case(part))
        };
        for node in robot.children().filter(is_part).flat_map(|part| part.descendants()) {
            let of_attributes = node.attributes().map(|attribute| attribute.name());
            for name in std::iter::once(node.tag_name().name()).chain(of_attributes) {
                let known = NAMES.split(' ').find(|known| known.eq_ignore_ascii_case(name) && *known != name);
                if let Some(known) = known {
                    let place = format!("<{}>", node.tag_name().name());
                    self.add(node, place, format!("the name `{name}` has capitals, expected `{known}`"));
                }
            }
        }
    }

    fn link(&mut self, node: Node) -> ModelLink {
        let name = self.text(node, "name", "link");
        let place = format!("link {name:?}");
        let shapes = children(node, "collision").filter_map(|solid| self.shape(solid, &place)).collect();
        ModelLink { name, line: self.line(node), shapes }
    }

    /// The pose in an element's `origin`: rotations about the fixed axes x, y, z, in this order.
    pub fn origin(&mut self, node: Node, place: &str) -> Pose {
        let Some(origin) = children(node, "origin").next() else { return Pose::IDENTITY };
        let place = format!("{place}, origin");
        let xyz = self.numbers(origin, "xyz", &place, Some([0.0; 3])).unwrap_or_default();
        let rpy = self.numbers(origin, "rpy", &place, Some([0.0; 3])).unwrap_or_default();
        let [roll, pitch, yaw] = rpy;
        let rotation = DQuat::from_euler(EulerRot::ZYX, yaw, pitch, roll);
        Pose::new(rotation, DVec3::from(xyz)).expect("numbers are of at most 1e6")
    }

    /// The numbers of an attribute, or the default if it is missing; `None` if they are invalid.
    pub fn numbers<const N: usize>(
        &mut self,
        node: Node,
        attribute: &str,
        place: &str,
        default: Option<[f64; N]>,
    ) -> Option<[f64; N]> {
        let count = if N == 1 { "a finite number".to_owned() } else { format!("{N} finite numbers") };
        let expected = format!("expected {count} of at most 1e6");
        let Some(text) = node.attribute(attribute) else {
            if default.is_none() {
                self.add(node, place, format!("`{attribute}` is missing, {expected}"));
            }
            return default;
        };
        let numbers: Result<Vec<f64>, _> = text.split_ascii_whitespace().map(str::parse).collect();
        let is_usable = |numbers: &[f64; N]| numbers.iter().all(|number| number.abs() <= LARGEST);
        let numbers = numbers.ok().and_then(|numbers| numbers.try_into().ok()).filter(is_usable);
        if numbers.is_none() {
            self.add(node, place, format!("`{attribute}` is {:?}, {expected}", shortened(text)));
        }
        numbers
    }

    /// A required, non-empty attribute.
    pub fn text(&mut self, node: Node, attribute: &str, place: &str) -> String {
        let text = node.attribute(attribute).unwrap_or_default();
        if text.is_empty() {
            self.add(node, place, format!("`{attribute}` is missing, expected a name"));
        }
        text.to_owned()
    }

    pub fn add(&mut self, node: Node, place: impl Into<String>, problem: impl Into<String>) {
        self.faults.push(UrdfFault::new(Some(self.line(node)), place, problem));
    }

    /// The line of an element, counted from 1. The document's own `text_pos_at` counts all lines on each
    /// call.
    pub fn line(&self, node: Node) -> u32 {
        self.line_starts.partition_point(|start| *start <= node.range().start) as u32
    }
}

/// The direct children of this name.
pub(super) fn children<'d>(node: Node<'d, 'd>, name: &'static str) -> impl Iterator<Item = Node<'d, 'd>> {
    node.children().filter(move |child| child.has_tag_name(name))
}

/// At most 60 characters, to keep messages readable.
pub(super) fn shortened(text: &str) -> String {
    text.chars().take(60).collect()
}
