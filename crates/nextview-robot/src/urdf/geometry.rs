use super::reader::{LARGEST, UrdfReader, children, shortened};
use crate::{Shape, ShapeKind};
use glam::DVec3;
use roxmltree::Node;

/// Relative thickness below which a hull is flat.
const FLAT: f64 = 1e-9;

impl UrdfReader<'_> {
    /// The solid of a `collision` element; `None` if it is invalid or takes up no space.
    pub fn shape(&mut self, node: Node, place: &str) -> Option<Shape> {
        let place = format!("{place}, collision");
        let link_from_shape = self.origin(node, &place);
        let solid = children(node, "geometry").next().and_then(|geometry| geometry.first_element_child());
        let Some(solid) = solid else {
            self.add(node, place, "has no <geometry> with a solid, expected box, sphere, cylinder or mesh");
            return None;
        };
        let name = solid.tag_name().name();
        let place = format!("{place}, {name}");
        let kind = match name {
            "box" => {
                let sides = self.sizes(solid, "size", &place)?;
                Some(ShapeKind::Box(DVec3::from(sides) / 2.0))
            }
            "sphere" => {
                let [radius] = self.sizes(solid, "radius", &place)?;
                Some(ShapeKind::Sphere(radius))
            }
            "cylinder" => {
                let radius = self.sizes(solid, "radius", &place);
                let length = self.sizes(solid, "length", &place);
                let ([radius], [length]) = (radius?, length?);
                Some(ShapeKind::Cylinder { radius, length })
            }
            "mesh" => self.hull(solid, &place),
            _ => {
                self.add(solid, place, "is unknown, expected box, sphere, cylinder or mesh");
                None
            }
        };
        kind.map(|kind| Shape { link_from_shape, kind })
    }

    /// Reads numbers that must be positive.
    fn sizes<const N: usize>(&mut self, node: Node, attribute: &str, place: &str) -> Option<[f64; N]> {
        let sizes = self.numbers(node, attribute, place, None)?;
        if sizes.iter().any(|size| *size <= 0.0) {
            let found = shortened(node.attribute(attribute).unwrap_or_default());
            self.add(node, place, format!("`{attribute}` is {found:?}, expected positive numbers"));
            return None;
        }
        Some(sizes)
    }

    fn hull(&mut self, node: Node, place: &str) -> Option<ShapeKind> {
        let file = self.text(node, "filename", place);
        let scale = DVec3::from(self.numbers(node, "scale", place, Some([1.0; 3]))?);
        if file.is_empty() {
            return None;
        }
        let points = match (self.options.load_mesh)(&file) {
            Ok(points) => points,
            Err(why) => {
                self.add(node, place, format!("{file:?} cannot be read: {why}"));
                return None;
            }
        };
        if points.is_empty() {
            return None;
        }
        let points: Vec<DVec3> = points.into_iter().map(|point| point * scale).collect();
        // Comparisons with NaN are false.
        let is_near = |point: &DVec3| point.abs().cmple(DVec3::splat(LARGEST)).all();
        if let Some(point) = points.iter().find(|point| !is_near(point)) {
            self.add(node, place, format!("{file:?} has a point at {point}, expected at most 1e6 m"));
            return None;
        }
        if is_flat(&points) {
            let expected = "expected at least four points that are not in a plane";
            self.add(node, place, format!("{file:?} is flat at scale {scale}, {expected}"));
            return None;
        }
        Some(ShapeKind::Hull(points))
    }
}

/// Whether points lie in a plane, up to rounding. The three that span the plane are far apart.
fn is_flat(points: &[DVec3]) -> bool {
    let first = points[0];
    let farthest = |distance: &dyn Fn(DVec3) -> f64| {
        points.iter().map(|point| *point - first).max_by(|a, b| distance(*a).total_cmp(&distance(*b)))
    };
    let Some(along) = farthest(&|offset| offset.length()) else { return true };
    let Some(aside) = farthest(&|offset| along.cross(offset).length()) else { return true };
    let size = along.length();
    let normal = along.cross(aside).normalize_or_zero();
    points.iter().all(|point| normal.dot(*point - first).abs() <= FLAT * size)
}
